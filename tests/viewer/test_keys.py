"""The one table of keys."""

import pytest

from glimt.viewer.commands import COMMANDS
from glimt.viewer.keys import KEYS, action_of, help_table, key_name


def down(key, *modifiers):
    return {"event_type": "key_down", "key": key, "modifiers": modifiers}


def test_every_key_is_in_the_table_once_and_does_something():
    names = [name for key in KEYS for name in key.keys]
    assert len(names) == len(set(names))
    assert {key.action for key in KEYS if not key.held} == set(COMMANDS)


def test_the_help_tells_of_every_key():
    text = " ".join(f"{keys} {help}" for _, keys, help in help_table())
    for key in KEYS:
        assert str(key) in text or key.action.startswith("recall_")
        assert key.help or key.action.startswith("recall_")


@pytest.mark.parametrize(("event", "action"), [
    (down("w"), "forward"), (down("W", "Shift"), "forward"), (down("ArrowUp"), "forward"), (down(" "), "up"),
    (down("l"), "add_light"), (down("L", "Shift"), "remove_light"), (down("L"), "remove_light"),
    (down("l", "Shift"), "remove_light"), (down("Shift", "Shift"), "down"), (down("?", "Shift"), "help"),
    (down("/", "Shift"), "help"), (down("F11"), "fullscreen"), (down("3"), "recall_3")])
def test_what_backends_send_is_understood(event, action):
    assert action_of(event).action == action


@pytest.mark.parametrize("event", [
    down("w", "Control"), down("r", "Meta"), down("l", "Alt"), down("x"), down(""), down("Tab"),
    {"event_type": "key_down"}, {"event_type": "key_down", "key": None}])
def test_what_is_not_ours_is_left_alone(event):
    assert action_of(event) is None


def test_names():
    assert key_name(down(" ")) == "Space"
    assert key_name(down("É", "Shift")) == "Shift+é"
