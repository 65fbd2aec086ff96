"""View files: camera, lights and settings of one picture, in the tables that scene files have."""

from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from glimt.errors import GlimtError, WarningCounter
from glimt.scene.light import DirectionalLight, Light, PointLight, SpotLight
from glimt.scene.scene import Scene

_PLACED = ("position", "radius", "attenuation")
_KEYS = {"point": _PLACED, "spot": (*_PLACED, "direction", "inner_angle_deg", "outer_angle_deg"),
         "directional": ("direction",)}


def view_text(scene: Scene, time: float = 0.0, note: str = "") -> str:
    """Return a view file for a scene's picture: TOML with its render settings, camera and lights.

    Parameters
    ----------
    scene : Scene
        With a camera.
    time : float
        Seconds; lights that move are written down where they stand then, without their motion.
    note : str
        Goes on top as a comment.
    """
    settings, camera = scene.settings, scene.camera_or_framing()
    lines = [f"# {line}" for line in note.splitlines()] + [""]
    lines += ["[render]", f"size = [{settings.width}, {settings.height}]"]
    lines += _keys(settings, "samples", "max_bounces", "background", "ambient", "exposure", "tone_curve")
    lines += ["", "[camera]", *_keys(camera, "position", "target", "up", "fov_deg")]
    for light in scene.lights:
        kind, still = _still(light, time)
        lines += ["", "[[light]]", f"type = {_toml(kind)}"]
        lines += _keys(still, "name", "ambient", "diffuse", "specular", *_KEYS[kind])
    return "\n".join(lines) + "\n"


def apply_view(scene: Scene, path: str | PathLike[str]) -> Scene:
    """Return the scene as a view file shows it: with the file's settings, camera and lights.

    Raises
    ------
    GlimtError
        Naming file, line and key; a view file has no objects.
    """
    from glimt.io.scene_file import read_view

    path = Path(fspath(path))
    if not path.is_file():
        raise GlimtError(f"{path}: {'not a regular file' if path.exists() else 'no such file'}")
    warnings = WarningCounter()
    view = read_view(path, warnings)
    warnings.issue()
    return replace(scene, camera=view.camera or scene.camera, lights=view.lights, settings=view.settings)


def _still(light: Light, time: float) -> tuple[str, Light]:
    """Return a light's type in files, and the light as it stands at a time."""
    if isinstance(light, DirectionalLight):
        return "directional", replace(light, direction=light.direction_at(time), motion=None)
    if isinstance(light, SpotLight):
        return "spot", replace(light, position=light.position_at(time), motion=None)
    if isinstance(light, PointLight):
        return "point", replace(light, position=light.position_at(time), motion=None)
    raise GlimtError(f"{light.owner}: a {type(light).__name__} cannot be written to a view file")


def _keys(thing: object, *names: str) -> list[str]:
    return [f"{name} = {_toml(getattr(thing, name))}" for name in names]


def _toml(value: Any) -> str:
    """Return a value as TOML; numbers keep every bit."""
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08X}" for c in escaped) + '"'
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_toml(part) for part in value) + "]"
    return repr(value) if isinstance(value, int) else repr(float(value))
