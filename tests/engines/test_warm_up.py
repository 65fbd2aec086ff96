"""Compiling on the first run: who compiles what, and that nothing is waited for in vain."""

import subprocess
import sys
import time

import pytest

from glimt.engines.cpu import warm_up


@pytest.mark.parametrize(("cores", "processes"), [(None, 0), (1, 0), (2, 1), (8, 2)])
def test_processes_share_what_there_is_to_compile(monkeypatch, cores, processes):
    started = []
    monkeypatch.setattr(warm_up, "is_ready", lambda kernel: False)
    monkeypatch.setattr(warm_up.os, "cpu_count", lambda: cores)
    monkeypatch.setattr(warm_up, "compile_elsewhere", started.append)  # none can be started
    warm_up.begin()
    assert len(started) == processes
    done = []
    for name in ("compile_traversal", "compile_before_and_after"):
        monkeypatch.setattr(warm_up, name, lambda name=name: done.append(name))
    for code in started:
        exec(code, {})
    assert done == (["compile_traversal", "compile_before_and_after"] if processes else [])


def test_processes_that_never_end_are_ended(monkeypatch):
    monkeypatch.setattr(warm_up, "_PATIENCE_SECONDS", 1)
    monkeypatch.setattr(warm_up, "is_ready", lambda kernel: False)
    sleeping = [subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"]) for _ in range(2)]
    helpers, start = warm_up.Helpers(sleeping), time.monotonic()
    helpers.wait_for_traversal()
    helpers.wait()
    assert all(process.poll() is not None for process in sleeping)
    assert time.monotonic() - start < 60


def test_a_process_that_has_ended_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(warm_up, "is_ready", lambda kernel: False)
    ended, start = subprocess.Popen([sys.executable, "-c", "raise SystemExit(1)"]), time.monotonic()
    helpers = warm_up.Helpers([ended])
    helpers.wait_for_traversal()
    helpers.wait()
    assert ended.returncode == 1
    assert time.monotonic() - start < 60
