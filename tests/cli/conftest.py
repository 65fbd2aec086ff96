"""What the tests of the command line share."""

import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from glimt.cli.app import app
from glimt.renderer import Renderer
from glimt.scene.scene import Scene

SCENE = """
[render]
size = [24, 16]
[[sphere]]
center = [0, 0, 0]
radius = 1
[[light]]
type = "point"
position = [3, 3, 3]
radius = 4
motion = { orbit = { period = 4 } }
"""


class Outcome(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session", autouse=True)
def _compiled():
    """Compile the kernels first, which the command would talk about."""
    Renderer(Scene(), progress=lambda stage, fraction: None)


@pytest.fixture
def glimt(capsys, monkeypatch, tmp_path):
    """Run a command in this process, in an empty folder with a scene file `ball.toml`."""
    (tmp_path / "ball.toml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["glimt", *arguments])
        with pytest.raises(SystemExit) as end:
            app()
        return Outcome(int(end.value.code or 0), *capsys.readouterr())
    return run


@pytest.fixture
def ball(tmp_path) -> Path:
    """Return a scene file."""
    (tmp_path / "ball.toml").write_text(SCENE)
    return tmp_path / "ball.toml"
