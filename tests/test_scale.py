"""No absolute epsilon: a scene of any size gives the same picture."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import glimt
from glimt import linalg

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def scaled(scene, factor):
    """Return the scene made `factor` times as large, lights and camera with it."""
    def point(p):
        return tuple(factor * x for x in p)

    grow = linalg.scaling(factor)
    objects = []
    for thing in scene.objects:
        if isinstance(thing, glimt.Sphere):
            objects.append(dataclasses.replace(thing, center=point(thing.center), radius=factor * thing.radius))
        else:
            objects.append(dataclasses.replace(thing, object_to_world=linalg.compose(grow, thing.object_to_world)))
    lights = []
    for light in scene.lights:
        moved = dataclasses.replace(light, motion=None)
        if isinstance(light, glimt.PointLight):
            moved = dataclasses.replace(moved, position=point(light.position), radius=factor * light.radius)
        lights.append(moved)
    camera = dataclasses.replace(scene.camera, position=point(scene.camera.position),
                                 target=point(scene.camera.target))
    return dataclasses.replace(scene, objects=objects, lights=lights, camera=camera)


@pytest.fixture(scope="module")
def scene():
    scene = glimt.load(EXAMPLES / "stone_room.toml")
    scene.settings = dataclasses.replace(scene.settings, width=400, height=400, samples=1, max_bounces=3)
    return scene


@pytest.fixture(scope="module")
def picture(scene):
    return glimt.render(scaled(scene, 1.0)).astype(int)


@pytest.mark.parametrize("factor", [1e-12, 1e-3, 0.37, 1e5, 1e14])
def test_size_does_not_matter(scene, picture, factor):
    difference = np.abs(glimt.render(scaled(scene, factor)).astype(int) - picture).max(-1)
    assert (difference > 2).mean() <= 0.001


def test_a_place_far_away_does_not_leak(scene, picture):
    """At 1000 m one float32 step is 0.06 mm: the picture keeps its shadows, edges may move by a pixel."""
    moved = scaled(scene, 1.0)
    offset = np.array([1000.0, -500.0, 800.0])
    for thing in moved.objects:
        if isinstance(thing, glimt.Sphere):
            thing.center = tuple(np.add(thing.center, offset))
        else:
            thing.object_to_world = linalg.compose(linalg.translation(offset), thing.object_to_world)
    for light in moved.lights:
        if isinstance(light, glimt.PointLight):
            light.position = tuple(np.add(light.position, offset))
    moved.camera = dataclasses.replace(moved.camera, position=tuple(np.add(moved.camera.position, offset)),
                                       target=tuple(np.add(moved.camera.target, offset)))
    difference = np.abs(glimt.render(moved).astype(int) - picture).max(-1)
    assert (difference > 8).mean() <= 0.01
