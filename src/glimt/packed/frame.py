"""What may change from frame to frame without an update: lights and the view. Plain floats; arrays come last."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt.color import exposure_scale
from glimt.layout import DIRECTIONAL_LIGHT, LIGHT, POINT_LIGHT, SPOT_LIGHT, VIEW, dtype
from glimt.scene import checks
from glimt.scene.camera import Camera
from glimt.scene.light import DirectionalLight, Light, PointLight, SpotLight
from glimt.scene.scene import RenderSettings

Triple = tuple[float, float, float]
LightRow = tuple[Any, ...]
"""The fields of a LIGHT record in order, as plain numbers: two rows compare."""

_ZERO = (0.0, 0.0, 0.0)


def light_rows(lights: list[Light], time: float) -> list[LightRow]:
    """Return the rows of lights as they stand at `time` seconds."""
    return [_light_row(light, time) for light in lights]


def pack_light_rows(rows: list[LightRow]) -> NDArray[np.float32]:
    """Return LIGHT records; one that is never read for no rows."""
    records = np.zeros(max(1, len(rows)), dtype(LIGHT))
    if rows:
        records[:] = rows
    return records.view(np.float32)


def pack_lights(lights: list[Light], time: float = 0.0) -> NDArray[np.float32]:
    """Return the LIGHT records of lights as they stand at `time` seconds."""
    return pack_light_rows(light_rows(lights, time))


def _light_row(light: Light, time: float) -> LightRow:
    checks.kind("scene", "one of lights", light, PointLight, DirectionalLight)
    kind, position, direction = int(POINT_LIGHT), _ZERO, _ZERO
    inverse_radius, attenuation, cone_scale, cone_offset = 0.0, _ZERO, 0.0, 0.0
    if isinstance(light, DirectionalLight):
        kind, direction = int(DIRECTIONAL_LIGHT), _unit(light.direction_at(time))
    elif isinstance(light, PointLight):
        position = _triple(light, "position", light.position_at(time))
        inverse_radius, attenuation = 1 / light.radius, color(light.owner, "attenuation", light.attenuation)
        if isinstance(light, SpotLight):
            inner, outer = light.cosines()
            kind, direction = int(SPOT_LIGHT), _unit(light.direction)
            cone_scale = 1 / max(inner - outer, 1e-6)
            cone_offset = -outer * cone_scale
    return (kind, position, direction, color(light.owner, "diffuse", light.diffuse),
            color(light.owner, "specular", light.specular), inverse_radius, attenuation, cone_scale, cone_offset, 0)


def pack_view(camera: Camera, settings: RenderSettings, lights: list[Light]) -> NDArray[np.float32]:
    """Return the VIEW record of a frame."""
    right, up, look = camera.axes()
    reach = math.tan(math.radians(camera.fov_deg) / 2)
    reach_x = reach * settings.width / settings.height
    ambient = color("settings", "ambient", settings.ambient)
    for light in lights:
        red, green, blue = color(light.owner, "ambient", light.ambient)
        ambient = ambient[0] + red, ambient[1] + green, ambient[2] + blue
    record = np.empty(1, dtype(VIEW))
    record[0] = (tuple(camera.position), _scaled(right, reach_x), _scaled(up, reach), look,
                 2 * reach / settings.height, color("settings", "background", settings.background), ambient,
                 exposure_scale(settings.exposure), settings.tone_curve == "filmic")
    return record.view(np.float32)


def color(owner: str, field: str, value: Any) -> Triple:
    """Return a colour as three numbers: what was set by hand since a constructor checked it may be one number."""
    return value if type(value) is tuple and len(value) == 3 else checks.color(owner, field, value)


def _scaled(v: Triple, factor: float) -> Triple:
    return v[0] * factor, v[1] * factor, v[2] * factor


def _triple(light: Light, field: str, value: Any) -> Triple:
    return value if type(value) is tuple else checks.vector(light.owner, field, value)


def _unit(direction: Any) -> Triple:
    x, y, z = direction
    length = math.hypot(x, y, z) or 1.0
    return float(x / length), float(y / length), float(z / length)
