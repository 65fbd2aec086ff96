"""What all tests share."""

from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]
SCENES = ROOT.parent / "shared" / "scenes"


@pytest.fixture(autouse=True)
def _strict_numpy():
    """Turn silent overflow and invalid operations of NumPy into errors."""
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.fixture(scope="session")
def real_scenes() -> Path:
    """Return the folder of real OBJ scenes, or skip: they are not part of the project."""
    if not SCENES.is_dir():
        pytest.skip(f"no real scenes at {SCENES}")
    return SCENES
