"""From a scene to a picture: choose the engine, pack, render."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glimt import bvh
from glimt.debug_view import DEBUG_VIEWS, DebugFilm, DebugView, light_tints
from glimt.engines import DEFAULT_OPTIONS, EngineOptions, Progress, get_engine
from glimt.errors import GlimtError
from glimt.film import Film
from glimt.layout import MISS, VIEW
from glimt.packed import Packer, light_rows, pack_light_rows, pack_view
from glimt.packed.frame import LightRow
from glimt.packed.meshes import mesh_tree
from glimt.pick import Pick, pick_from
from glimt.scene import checks
from glimt.scene.camera import Camera
from glimt.scene.scene import Samples, Scene
from glimt.scene.sphere import Sphere


@dataclass(frozen=True)
class SceneStats:
    """Numbers of a packed scene; `placed_triangles` counts a mesh once for each instance."""

    triangles: int
    placed_triangles: int
    meshes: int
    instances: int
    spheres: int
    lights: int
    materials: int
    textures: int
    texture_bytes: int
    tree_depth: int
    tree_nodes: int
    sah_cost: float
    memory_bytes: int


class Renderer:
    """Renders one scene any number of times; keeps what need not be made again.

    The camera, the settings and the lights of `scene` may change between frames. After a change of objects or
    materials call `update`.

    Parameters
    ----------
    scene : Scene
    threads : int, optional
        None: as many as the process may use.
    engine : "auto", "cpu" or "gpu"
        "auto" is a GPU where there is one and wgpu is installed.
    progress : Progress, optional
        Is told about compiling and building.
    options : EngineOptions
        For measurements.
    on_failure : function, optional
        Is told what happened when the CPU takes over from a GPU that fails: its driver was reset, or it has no memory
        for a scene or picture. None: with "auto" a `GlimtWarning` tells it; "gpu" is the GPU or an error.
    """

    def __init__(self, scene: Scene, *, threads: int | None = None, engine: str = "auto",
                 progress: Progress | None = None, options: EngineOptions = DEFAULT_OPTIONS,
                 on_failure: Callable[[str], None] | None = None) -> None:
        self.scene = scene
        self._engine = get_engine(engine, threads, options, on_failure)
        self._engine.prepare(progress)
        self._packer = Packer(self._engine.threads, options.brute_force)
        self.update(progress)

    @property
    def threads(self) -> int:
        """How many threads the engine uses on this machine."""
        return self._engine.threads

    @property
    def engine_name(self) -> str:
        """What computes: "CPU, 8 threads", or the name of a GPU."""
        return self._engine.description

    def is_ready(self, samples: Samples, view: DebugView | None = None) -> bool:
        """Return whether a picture with such samples, or a debug view, can be rendered without compiling first."""
        return self._engine.is_ready(samples, view)

    def keep_films(self) -> Any:
        """Leave films on the GPU that renders them, for a window of the same GPU: `Film.sums` come when they are read.

        Returns
        -------
        The GPU's device, or None where there is no GPU at work and films are in memory anyway.
        """
        return self._engine.keep_films()

    def update(self, progress: Progress | None = None) -> None:
        """Take over changed objects and materials.

        What has not changed is kept: trees above all. Meshes and the pixels of textures are never changed in place; a
        moved mesh is another one (`Mesh.with_positions`).
        """
        if progress:
            progress("building trees", 0.0)
        self._packed = self._packer.pack(self.scene)
        self._objects = list(self.scene.objects)
        # By packed instance, its place in the scene's objects: meshes without triangles are not packed.
        self._placed = [k for k, thing in enumerate(self._objects)
                        if isinstance(thing, Sphere) or len(thing.mesh.triangles)]
        self._light_rows: list[LightRow] | None = None
        self._framing: tuple[float, Camera] | None = None

    def render(self, time: float = 0.0, progress: Progress | None = None, film: Film | None = None) -> Film:
        """Render the scene with lights as they stand at `time` seconds; `film` is one that may be written over."""
        settings = self.scene.settings
        self._upload(time)
        if self._engine.uses_clearances:
            self._packer.clearances().begin_picture()
        return self._engine.render(self._view(), (settings.width, settings.height), settings.samples,
                                   settings.max_bounces, progress, film)

    def settle(self) -> None:
        """Wait for what is worked out beside the pictures so that later ones become faster.

        It begins with the second picture by itself. Whoever measures pictures calls this first.
        """
        if self._engine.uses_clearances:
            self._packer.clearances().finish()

    def render_debug(self, view: DebugView, time: float = 0.0, light: int | None = None) -> DebugFilm:
        """Render numbers a pixel instead of radiance, one ray each; `DebugFilm.image` shows them.

        Parameters
        ----------
        view : "normals", "depth", "barycentrics", "instances", "nodes" or "shadows"
            See `DebugFilm`.
        time : float
            Seconds, as for `render`.
        light : int, optional
            The only light that "shadows" shows; None: all of them.
        """
        if view not in DEBUG_VIEWS:
            raise GlimtError(f"there is no debug view {view!r}; expected one of {', '.join(DEBUG_VIEWS)}")
        scene, settings = self.scene, self.scene.settings
        tints = light_tints(len(scene.lights), light)
        self._upload(time)
        values = self._engine.render_debug(self._view(), (settings.width, settings.height), view, tints)
        if view == "instances" and len(self._placed) < len(self._objects):
            met, numbers = values[..., 3] > 0, values.view(np.int32)[..., 0]
            numbers[met] = np.array(self._placed, np.int32)[numbers[met]]
        return DebugFilm(view, values)

    def pick(self, x: float, y: float, time: float = 0.0) -> Pick | None:
        """Return what is seen at a point of the picture, or None where that is the background.

        Another thread may be rendering meanwhile.

        Parameters
        ----------
        x, y : float
            In pixels from the top left corner of a picture of the settings' size; the centre of the first is (0.5,
            0.5). The plane of the picture goes on beyond its edges.
        time : float
            Seconds, as for `render`; so far objects stand still.
        """
        x, y = (checks.number("pick", axis, value, -1e6, 1e6) for axis, value in (("x", x), ("y", y)))
        settings, words = self.scene.settings, self._view().astype(np.float64)
        origin, right, up, look = (words[at:at + 3] for at in (VIEW.origin, VIEW.right, VIEW.up, VIEW.look))
        direction = look + (2 * x / settings.width - 1) * right + (1 - 2 * y / settings.height) * up
        if self._light_rows is None:  # else what is there will do: lights are not picked, and a render may need them
            self._upload(time)
        hits = self._engine.find_hits(np.array([*origin, *direction, np.inf], np.float32)[:, None])
        if hits.inst[0] == MISS:
            return None
        index = self._placed[hits.inst[0]]
        return pick_from(self._objects[index], index, int(hits.prim[0]), float(hits.u[0]), float(hits.v[0]), origin,
                         origin + float(hits.t[0]) * direction)

    def _upload(self, time: float) -> None:
        """Have the engine know the scene with its lights as they stand at `time` seconds."""
        rows = light_rows(self.scene.lights, checks.number("render", "time", time, -1e12, 1e12))
        if rows != self._light_rows:
            self._packed = self._packed._replace(lights=pack_light_rows(rows))
            self._engine.upload(self._packed, len(rows))
            self._light_rows = rows

    def _view(self) -> NDArray[np.float32]:
        """Return the VIEW record of the next picture."""
        return pack_view(self.scene.camera or self._framed(), self.scene.settings, self.scene.lights)

    def cancel(self) -> None:
        """Stop the render that another thread is in: there it raises `RenderCancelled` within a few packets' time.

        With no render running nothing happens, also not to the next one. What is only run on the way to the first
        picture, compiling and `update`, is not stopped; rendering then stops when it begins.
        """
        self._engine.cancel()

    def _framed(self) -> Camera:
        """Return a camera that frames all objects as they were at the last update, for a scene that has none."""
        aspect = self.scene.settings.width / self.scene.settings.height
        if self._framing is None or self._framing[0] != aspect:
            self._framing = aspect, self.scene.camera_or_framing()
        return self._framing[1]

    def stats(self) -> SceneStats:
        """Return what the scene is made of."""
        scene, packed = self.scene, self._packed
        meshes = list({id(thing.mesh): thing.mesh for thing in scene.instances()}.values())
        trees = [bvh.tree_stats(mesh_tree(mesh)) for mesh in meshes if len(mesh.triangles)]
        materials = {id(m) for mesh in meshes for m in mesh.materials}
        materials |= {id(thing.material) for thing in scene.objects if getattr(thing, "material", None)}
        return SceneStats(
            triangles=sum(len(mesh.triangles) for mesh in meshes),
            placed_triangles=scene.placed_triangles(),
            meshes=len(meshes), instances=len(scene.instances()), spheres=len(scene.spheres()),
            lights=len(scene.lights), materials=len(materials), textures=packed.texture_count,
            texture_bytes=packed.texels.nbytes, tree_depth=max((tree.depth for tree in trees), default=0),
            tree_nodes=sum(tree.nodes for tree in trees), sah_cost=sum(tree.sah_cost for tree in trees),
            memory_bytes=packed.memory_bytes())


def render(scene: Scene, *, size: tuple[int, int] | None = None, samples: Samples | None = None,
           max_bounces: int | None = None, threads: int | None = None, engine: str = "cpu", time: float = 0.0,
           linear: bool = False) -> NDArray[Any]:
    """Render a scene.

    Parameters
    ----------
    scene : Scene
    size : (width, height), optional
        Pixels; this and the next two default to the scene's settings.
    samples : int or "adaptive", optional
        n for n×n samples a pixel; "adaptive" takes up to 4×4 where the picture needs them.
    max_bounces : int, optional
    threads : int, optional
    engine : "cpu", "gpu" or "auto"
        The CPU has finished most single pictures before a GPU is ready.
    time : float
        Seconds, for lights that move.
    linear : bool
        True returns linear radiance instead of a displayable image.

    Returns
    -------
    (height, width, 3) uint8 sRGB, or float32 linear RGB; row 0 on top.

    Raises
    ------
    GlimtError
        For settings out of range.
    """
    changes: dict[str, Any] = {"samples": samples, "max_bounces": max_bounces}
    if size is not None:
        changes["width"], changes["height"] = size
    settings = replace(scene.settings, **{name: value for name, value in changes.items() if value is not None})
    film = Renderer(replace(scene, settings=settings), threads=threads, engine=engine).render(time)
    if linear:
        return np.ascontiguousarray(film.radiance)
    return film.image(settings.exposure, settings.tone_curve)
