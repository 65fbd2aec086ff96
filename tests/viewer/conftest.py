"""A viewer of a scene that renders in no time."""

import pytest
from viewer_driver import Driver, make_scene

from glimt.viewer.viewer import Viewer


@pytest.fixture
def driver(tmp_path):
    """Return a driver of a viewer, 80×60, that keeps its files in a folder of the test."""
    viewer = Viewer(make_scene(), threads=2)
    viewer.folder = tmp_path
    yield Driver(viewer)
    viewer.presenter.close()
