"""A TOML scene file to a Scene; `docs/scene-format.md` describes the format."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from glimt import linalg
from glimt.errors import GlimtError, WarningCounter
from glimt.io.image import TextureCache
from glimt.io.obj import read_obj
from glimt.io.scene_document import SceneDocument
from glimt.io.scene_schema import (
    AnyLightTable,
    InstanceTable,
    MaterialTable,
    MeshTable,
    MotionTable,
    TextureTable,
    nearest,
)
from glimt.scene.camera import Camera
from glimt.scene.instance import Instance
from glimt.scene.light import DirectionalLight, Light, PointLight, SpotLight
from glimt.scene.material import Material
from glimt.scene.mesh import Mesh
from glimt.scene.motion import Motion, Orbit
from glimt.scene.motion import Path as MotionPath
from glimt.scene.scene import RenderSettings, Scene
from glimt.scene.sphere import Sphere
from glimt.scene.texture import Encoding, Texture

_LIGHTS: dict[str, type[Light]] = {"point": PointLight, "spot": SpotLight, "directional": DirectionalLight}

Named = TypeVar("Named", Material, Mesh)


def read_scene(path: Path) -> Scene:
    """Return the scene of a TOML file; meshes and textures it names are read too.

    What can be mended without guessing is a `GlimtWarning`; anything else wrong is a `GlimtError` that names the
    file, the line and the key.
    """
    warnings = WarningCounter()
    with np.errstate(over="ignore", invalid="ignore"):  # what becomes infinite is refused by the constructors
        scene = _SceneReader(SceneDocument(path), warnings).scene()
    if not scene.lights:
        warnings.add("no lights, only ambient light is seen; add a [[light]]", str(path))
    if not scene.objects:
        warnings.add("no objects, only the background is seen; add a [[mesh]] or [[sphere]]", str(path))
    warnings.issue()
    return scene


def read_view(path: Path, warnings: WarningCounter) -> Scene:
    """Return a scene with the settings, camera and lights of a view file, and without objects."""
    document = SceneDocument(path)
    for name in ("material", "mesh", "instance", "sphere"):
        if getattr(document.tables, name):
            raise document.error("has no place in a view file: it shows another file's scene", name, 0)
    return _SceneReader(document, warnings).scene()


class _SceneReader:
    """Builds the scene of one document; each file it refers to is read once."""

    def __init__(self, document: SceneDocument, warnings: WarningCounter) -> None:
        self.document = document
        self.tables = document.tables
        self.warnings = warnings
        self.textures = TextureCache()
        self.obj_files: dict[Path, Mesh] = {}
        self.materials: dict[str, Material] = {}
        self.meshes: dict[str, Mesh] = {}
        self.folder = document.path.parent.resolve()
        # One folder up, so that scenes can share meshes; but never the whole disk.
        self.reach = self.folder.parent if self.folder.parent.parent != self.folder.parent else self.folder

    def scene(self) -> Scene:
        settings, camera = self._settings(), self._camera()
        for index, table in enumerate(self.tables.material):
            self._register(self.materials, self._material(table, index), table.name, "material", index)
        unnamed = [mesh for index, table in enumerate(self.tables.mesh) if (mesh := self._mesh(table, index))]
        instances = [self._instance(table, index) for index, table in enumerate(self.tables.instance)]
        placed = {id(instance.mesh) for instance in instances}
        standing = [mesh for mesh in (*self.meshes.values(), *unnamed) if id(mesh) not in placed]
        scene = Scene(camera=camera, settings=settings, name=self.document.path.stem)
        scene.add(*standing, *instances, *self._spheres())
        return scene.add(*(self._light(table, index) for index, table in enumerate(self.tables.light)))

    def _settings(self) -> RenderSettings:
        table = self.tables.render
        with self.document.blame("render", "size"):
            width, height = table.size
            settings = RenderSettings(width, height)
        with self.document.blame("render"):
            return dataclasses.replace(settings, **table.given("size"))

    def _camera(self) -> Camera | None:
        if self.tables.camera is None:
            return None
        with self.document.blame("camera"):
            return Camera(**self.tables.camera.given())

    def _material(self, table: MaterialTable, index: int) -> Material:
        diffuse = self._texture(table.diffuse_texture, "srgb", index, "diffuse_texture")
        normal = self._texture(table.normal_texture, "linear", index, "normal_texture")
        with self.document.blame("material", index):
            return Material(diffuse_texture=diffuse, normal_texture=normal,
                            **table.given("diffuse_texture", "normal_texture"))

    def _texture(self, table: TextureTable | None, encoding: Encoding, index: int, key: str) -> Texture | None:
        if table is None:
            return None
        place = ("material", index, key)
        path = self._resolve(table.file, *place, "file")
        with self.document.blame(*place):
            return self.textures.texture(path, encoding=table.encoding or encoding, wrap=table.wrap,
                                         scale=(table.scale[0], table.scale[1]),
                                         offset=(table.offset[0], table.offset[1]))

    def _mesh(self, table: MeshTable, index: int) -> Mesh | None:
        """Register a mesh under its name; return one without a name, which no instance can refer to."""
        place = ("mesh", index)
        if (table.file is None) == (table.positions is None):
            raise self.document.error("expected either file or positions and triangles", *place)
        if table.file is None:
            mesh = self._inline_mesh(table, index)
        else:
            inline = table.given("name", "file", "material")
            if inline:
                raise self.document.error("not with file, the file says it", *place, next(iter(inline)))
            mesh = self._obj_mesh(table.file, index)
        mesh = dataclasses.replace(mesh, name=table.name or mesh.name)
        if table.material is not None:
            material = self._find(self.materials, table.material, *place, "material")
            mesh = dataclasses.replace(mesh, materials=[material], material_ids=None)
        if table.name is None:
            return mesh
        self._register(self.meshes, mesh, table.name, "mesh", index)
        return None

    def _inline_mesh(self, table: MeshTable, index: int) -> Mesh:
        if table.triangles is None:
            raise self.document.error("missing, positions alone draw nothing", "mesh", index, "triangles")
        with self.document.blame("mesh", index):
            return Mesh(np.array(table.positions), np.array(table.triangles), _rows(table.normals),
                        _rows(table.texcoords))

    def _obj_mesh(self, file: str, index: int) -> Mesh:
        place = ("mesh", index, "file")
        path = self._resolve(file, *place)
        if path.suffix.lower() != ".obj":
            raise self.document.error(f"{file!r} is not an OBJ file, the one format meshes are read from", *place)
        if path not in self.obj_files:
            with self.document.blame(*place):
                self.obj_files[path] = read_obj(path, warnings=self.warnings, textures=self.textures)
        return self.obj_files[path]

    def _instance(self, table: InstanceTable, index: int) -> Instance:
        place = ("instance", index)
        if table.matrix is not None and (table.scale or table.rotate or table.translate):
            raise self.document.error("either matrix or scale, rotate and translate, not both", *place, "matrix")
        mesh = self._find(self.meshes, table.mesh, *place, "mesh")
        material = table.material and self._find(self.materials, table.material, *place, "material")
        with self.document.blame(*place):
            return Instance(mesh, _object_to_world(table), material or None, **table.given(
                "mesh", "material", "matrix", "scale", "rotate", "translate"))

    def _spheres(self) -> list[Sphere]:
        spheres = []
        for index, table in enumerate(self.tables.sphere):
            options = table.given("material")
            if table.material is not None:
                options["material"] = self._find(self.materials, table.material, "sphere", index, "material")
            with self.document.blame("sphere", index):
                spheres.append(Sphere(**options))
        return spheres

    def _light(self, table: AnyLightTable, index: int) -> Light:
        motion = None
        if table.motion is not None:
            with self.document.blame("light", index, "motion", "orbit" if table.motion.orbit else "path"):
                motion = _motion(table.motion)
        with self.document.blame("light", index):
            return _LIGHTS[table.type](motion=motion, **table.given("type", "motion"))

    def _register(self, known: dict[str, Named], thing: Named, name: str, kind: str, index: int) -> None:
        if name in known:
            raise self.document.error(f"a second {kind} called {name!r}, rename one of them", kind, index, "name")
        known[name] = thing

    def _find(self, known: dict[str, Named], name: str, *place: str | int) -> Named:
        if name not in known:
            raise self.document.error(f"no [[{place[-1]}]] is called {name!r}{nearest(name, known)}", *place)
        return known[name]

    def _resolve(self, name: str, *place: str | int) -> Path:
        """Return the file that `name` means; a scene from a stranger must not read the whole disk."""
        path = self.document.path.parent / name.replace("\\", "/")
        try:
            if not path.resolve().is_relative_to(self.reach):
                raise self.document.error(f"{name!r} lies outside {self.reach}; a scene refers to files in its own "
                                          "folder or the one above it", *place)
            if not path.is_file():
                reason = "is not a regular file" if path.exists() else "is not there; paths start at the scene file"
                raise self.document.error(f"{name!r} {reason}", *place)
        except (OSError, ValueError, RuntimeError):  # a NUL, a name too long, a loop of links
            raise self.document.error(f"{name[:100]!r} is not a path", *place) from None
        return path


def _object_to_world(table: InstanceTable) -> NDArray[np.float64]:
    if table.matrix is not None:
        return np.array(table.matrix)
    transform = linalg.identity() if table.scale is None else linalg.scaling(table.scale)
    for turn in table.rotate or []:
        if not any(turn.axis):
            raise GlimtError("rotate has a zero vector as axis, which points nowhere")
        transform = linalg.compose(linalg.rotation(turn.axis, turn.angle_deg), transform)
    if table.translate is not None:
        transform[:, 3] = table.translate
    return transform


def _motion(table: MotionTable) -> Motion:
    if table.orbit is not None:
        center, axis = table.orbit.center, table.orbit.axis
        return Orbit((center[0], center[1], center[2]), (axis[0], axis[1], axis[2]), table.orbit.period)
    assert table.path is not None  # the schema asks for one of the two
    points = tuple((x, y, z) for x, y, z in table.path.points)
    return MotionPath(tuple(table.path.times), points, table.path.loop)


def _rows(values: Sequence[Sequence[float]] | None) -> NDArray[Any] | None:
    return None if values is None else np.array(values, np.float64)
