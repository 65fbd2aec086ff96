"""A mesh file without a scene file: camera, lights and settings that suit any mesh."""

from pathlib import Path

import numpy as np

from glimt.io.obj import read_obj
from glimt.scene.camera import Basis, Camera
from glimt.scene.light import DirectionalLight
from glimt.scene.scene import RenderSettings, Scene


def read_bare_mesh(path: Path) -> Scene:
    """Return a scene of the OBJ file as modelled; its camera is None, so that it is framed when it is rendered."""
    settings = RenderSettings(640, 480, samples=2, max_bounces=2, background=(0.32, 0.36, 0.42), ambient=0.08)
    scene = Scene(settings=settings, name=path.stem).add(read_obj(path))
    return scene.add(*_lights(Camera.framing(*scene.bounds()).basis()))


def _lights(view: Basis) -> list[DirectionalLight]:
    """Return a key light, a fill light and one from the camera: directional, so that no scale has to be known.

    Together they light a white surface to about 1; many MTL files have no ambient colour, so they leave nothing black
    that the camera sees.
    """
    return [
        _light("key", view, right=0.7, up=-0.9, diffuse=0.72, specular=0.72),
        _light("fill", view, right=-0.9, up=-0.15, diffuse=0.2, specular=0.0),
        _light("camera", view, right=0.0, up=0.0, diffuse=0.18, specular=0.0),
    ]


def _light(name: str, view: Basis, *, right: float, up: float, diffuse: float, specular: float) -> DirectionalLight:
    """Return a light that travels as the view goes, and to the right and up in it by these shares."""
    x, y, z = np.asarray(view.look + right * view.right + up * view.up).tolist()
    return DirectionalLight(direction=(x, y, z), diffuse=diffuse, specular=specular, name=name)
