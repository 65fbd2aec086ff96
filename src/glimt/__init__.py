"""Real-time ray tracing for Python: `glimt.save_image("room.png", glimt.render(glimt.load("room.obj")))`."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from glimt.errors import GlimtError, GlimtWarning
    from glimt.film import Film
    from glimt.io import load
    from glimt.io.image import save_image
    from glimt.renderer import Renderer, render
    from glimt.scene.camera import Camera
    from glimt.scene.instance import Instance
    from glimt.scene.light import DirectionalLight, PointLight, SpotLight
    from glimt.scene.material import Material
    from glimt.scene.mesh import Mesh
    from glimt.scene.motion import Orbit, Path
    from glimt.scene.scene import RenderSettings, Scene
    from glimt.scene.sphere import Sphere
    from glimt.scene.texture import Texture
    from glimt.viewer import view

__version__ = "0.1.0"

# Names are imported when they are first used: `import glimt` costs a millisecond, opens nothing and compiles nothing.
_HOMES = {
    "Camera": "scene.camera", "DirectionalLight": "scene.light", "Film": "film", "GlimtError": "errors",
    "GlimtWarning": "errors", "Instance": "scene.instance", "Material": "scene.material", "Mesh": "scene.mesh",
    "Orbit": "scene.motion", "Path": "scene.motion", "PointLight": "scene.light", "RenderSettings": "scene.scene",
    "Renderer": "renderer", "Scene": "scene.scene", "Sphere": "scene.sphere", "SpotLight": "scene.light",
    "Texture": "scene.texture", "load": "io", "render": "renderer", "save_image": "io.image",
    "view": "viewer",
}

__all__ = [
    "Camera", "DirectionalLight", "Film", "GlimtError", "GlimtWarning", "Instance", "Material", "Mesh", "Orbit", "Path",
    "PointLight", "RenderSettings", "Renderer", "Scene", "Sphere", "SpotLight", "Texture", "load", "render",
    "save_image", "view",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'glimt' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"glimt.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
