"""Warnings that are counted instead of repeated."""

import warnings

import pytest

from glimt import GlimtError, GlimtWarning
from glimt.errors import WarningCounter


def test_each_kind_is_issued_once_with_its_count_and_first_place():
    counter = WarningCounter()
    for line in (7, 9, 12):
        counter.add("a face is dropped", f"room.obj:{line}")
    counter.add("no library", "room.obj:1")
    counter.add("by the dozen", "here", 12)
    with pytest.warns(GlimtWarning) as caught:
        counter.issue()
    assert [str(warning.message) for warning in caught] == [
        "room.obj:7: a face is dropped (3 times, the first one here)", "room.obj:1: no library",
        "here: by the dozen (12 times, the first one here)"]
    assert [warning.message.count for warning in caught] == [3, 1, 12]


def test_issuing_forgets():
    counter = WarningCounter()
    counter.add("once")
    with pytest.warns(GlimtWarning, match="^once$"):
        counter.issue()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        counter.issue()


def test_one_family():
    assert issubclass(GlimtWarning, UserWarning)
    assert GlimtError.__mro__[1] is Exception
    assert GlimtWarning("text").count == 1
