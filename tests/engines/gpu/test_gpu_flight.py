"""A flight on the GPU tells what its stages take."""

from pathlib import Path

import pytest

import glimt
from glimt.bench import flight
from glimt.bench.tables import table

STONE_ROOM = Path(__file__).resolve().parents[3] / "examples" / "stone_room.toml"

pytestmark = pytest.mark.usefixtures("software_gpu")


def test_stages_are_measured_where_the_engine_times_them():
    gpu, cpu = (flight.measure(glimt.load(STONE_ROOM), (64, 48), 1, None, 0.5, 1 / 30, 1, engine)
                for engine in ("gpu", "cpu"))
    taken = gpu["rows"][0]["stage_ms"]
    assert set(taken) == {"create_rays", "intersect", "shade", "bounce", "resolve"}
    assert all(0 < each < 1000 for each in taken.values())
    assert f"{gpu['rows'][0]['engine']}, ms of a picture: create rays {taken['create_rays']:.2f}, " in table(gpu)
    assert cpu["rows"][0]["stage_ms"] == {}
    assert "ms of a picture" not in table(cpu)
