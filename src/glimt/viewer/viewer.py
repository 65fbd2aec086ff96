"""The viewer without a window: events in, pictures out. It knows no canvas, no thread and no engine."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from glimt.debug_view import DebugView
from glimt.engines import Progress
from glimt.errors import EngineError, GlimtError, RenderCancelled
from glimt.film import Film
from glimt.pick import Pick
from glimt.renderer import Renderer
from glimt.scene.camera import Camera
from glimt.scene.scene import Samples, Scene
from glimt.viewer.controls import Controls
from glimt.viewer.governor import DEFAULT_BUDGET, Governor
from glimt.viewer.keys import Event
from glimt.viewer.motion import NEAREST_SECONDS, Motion
from glimt.viewer.overlay import FrameTimes
from glimt.viewer.pose import Pose, dot, minus
from glimt.viewer.presenter import Picture, Presenter
from glimt.viewer.screenshot import keep_in

REST_SECONDS = 0.15
"""How long nothing must have moved before the picture is refined: a tapped key does not make it flicker."""
MESSAGE_SECONDS = 2.5
_FAILURE_SECONDS = 10.0
FINEST_SAMPLES = 4
_COMPILING = "compiling, the first time only"
_LONGEST_STEP = 0.25
"""Seconds: lights have not moved while nobody looked."""
_CROSSING_SECONDS = 8.0
"""How long a flight through the whole scene takes."""


class Host(Protocol):
    """What a window, a page or a terminal can be asked to do, from the thread that makes the pictures."""

    @property
    def is_fullscreen(self) -> bool:
        """Whether the screen is filled: a person may end that without a key of ours."""

    def set_pointer_captured(self, captured: bool) -> None:
        """Hide the pointer and report its moves without end, or give it back."""

    def set_fullscreen(self, fullscreen: bool) -> None:
        """Fill the screen, or no longer."""

    def keep(self, folder: Path, files: dict[str, bytes]) -> str:
        """Keep files for the user, by name, in a folder if they stay here; return what to tell where they are."""


class Viewer:
    """Looks at one scene: applies events, moves the camera and lights, decides what to render next.

    Parameters
    ----------
    scene : Scene
        Is not changed; objects and meshes are shared.
    budget : float
        Seconds a frame may take while anything moves.
    threads, engine, progress
        As for `Renderer`; but the CPU takes over from a GPU that fails even where "gpu" was chosen.
    host : Host, optional

    Attributes
    ----------
    scene : Scene
        A copy whose camera, lights and settings are what is seen.
    size : (width, height)
        Pixels of the canvas.
    pose, motion, time, governor, times : the camera, how it moves, seconds of the lights' clock, and so on
    triangles : int
        Those of a mesh once for each instance.
    """

    def __init__(self, scene: Scene, *, budget: float = DEFAULT_BUDGET, threads: int | None = None,
                 engine: str = "auto", progress: Progress | None = None, host: Host | None = None) -> None:
        self.scene = replace(scene, lights=list(scene.lights), settings=replace(scene.settings))
        self.jobs: list[Callable[[], None]] = []
        self.renderer = Renderer(self.scene, threads=threads, engine=engine, progress=progress,
                                 on_failure=self._tell_of_failure)
        self.host = host
        self.size = scene.settings.width, scene.settings.height
        self.pixel_ratio = 1.0
        self.samples: Samples = scene.settings.samples
        self.controls = Controls(self)
        self.governor = Governor(budget)
        self.times = FrameTimes()
        self.presenter = Presenter(self.renderer.threads)
        self.saved: dict[int, Pose] = {}
        self.pose = self.first_pose = Pose.of(self._camera())
        self.motion = Motion(self.scene_size() / _CROSSING_SECONDS)
        self.time = 0.0
        self.time_runs = True
        self.paused = False
        self.mouse_look = self.help_shown = self.saving_view = False
        self.debug_view: DebugView | None = None
        self.overlay_level = 1
        self.picked: Pick | None = None
        self.message: str | None = None
        self.error: str | None = None
        self.film: Film | None = None
        self.film_samples: Samples = self.samples
        self.frame_seconds = 0.0
        self.rendered_size = self.size
        self.folder = Path.cwd()
        self._films: dict[tuple[int, int], Film] = {}
        self._message_ends = math.inf
        self.now = 0.0
        self._last: float | None = None
        self._still_since = -math.inf
        self._stage = 0
        self._changed = self._uncovered = True
        self._refining = self._interrupted = False
        self.triangles = self.scene.placed_triangles()

    # ---- what others tell it -------------------------------------------------------------------------------------

    def handle(self, event: Event, now: float) -> None:
        """Apply an event of rendercanvas: resize, keys, pointer, wheel."""
        if not self._moves():
            self._last = now  # what begins to move now has not moved before
        self.now = now
        self.controls.handle(event)

    def interrupt(self) -> None:
        """End a refinement that is under way, from any thread: something has happened."""
        self._interrupted = True
        if self._refining:
            self.renderer.cancel()

    def resize(self, width: int, height: int, pixel_ratio: float = 1.0) -> None:
        """Take over the canvas' size in physical pixels."""
        self.pixel_ratio = pixel_ratio
        if (width, height) != self.size and width > 0 and height > 0:
            self.size = width, height
            self.changed()

    def find(self, x: float, y: float) -> Pick | None:
        """Return what is seen at a pixel of the canvas."""
        self._aim(self.size)
        return self.renderer.pick(x, y, self.time)

    def scene_size(self) -> float:
        """Return the length of the diagonal of the box around everything."""
        lo, hi = self.scene.bounds()
        size = float(np.linalg.norm(hi - lo))
        if not math.isfinite(size):
            raise GlimtError(f"{self.scene.name}: the scene is too large to be flown through")
        return size or 1.0

    def target_distance(self) -> float:
        """Return how far away what is looked at is: the target, or about as much as is seen of the scene."""
        target = self.motion.target
        if target is None:
            return self.motion.speed * _CROSSING_SECONDS / 4
        return max(dot(minus(target, self.pose.position), self.pose.look), NEAREST_SECONDS * self.motion.speed)

    def changed(self) -> None:
        """Take note that the picture is no longer right."""
        self._changed = True

    def say(self, message: str, seconds: float = MESSAGE_SECONDS) -> None:
        """Show a message for a while."""
        self.message, self._message_ends = message, self.now + seconds
        self.uncover()

    def fail(self, error: str) -> None:
        """Show what is wrong with the scene's files over the last good picture, until they are mended."""
        self.error = error
        self.uncover()

    def uncover(self) -> None:
        """Take note that what lies over the picture is no longer right."""
        self._uncovered = True

    def replace_scene(self, scene: Scene) -> None:
        """Go on with another version of the scene: the view stays, but for a camera, lights or settings it changed."""
        before = vars(self.scene).copy()
        vars(self.scene).update(vars(replace(scene, lights=list(scene.lights), settings=replace(scene.settings))))
        try:
            self.renderer.update()
        except GlimtError as error:
            vars(self.scene).update(before)
            self.renderer.update()
            self.fail(str(error))
            return
        self.triangles = self.scene.placed_triangles()
        first = Pose.of(self._camera())
        if first != self.first_pose:
            self.pose = self.first_pose = first
        self.samples, self.picked, self.error = self.scene.settings.samples, None, None
        self.changed()

    def finest(self) -> NDArray[np.uint8]:
        """Return the picture at rest, (h, w, 4) uint8 without overlay; it is rendered unless it is shown already."""
        samples = self._stages()[-1]
        if self._changed or (self.rendered_size, self.film_samples) != (self.size, samples):
            self._render(self.size, samples)
            self.rendered_size = self.size
        try:
            return self.presenter.picture()
        except EngineError:  # it was on a GPU that is lost; another engine takes over
            self._render(self.size, samples)
            return self.presenter.picture()

    def leave_gpu(self) -> None:
        """Have pictures pass through memory from now on: a window cannot show those of its GPU any more."""
        self.presenter.leave_gpu()
        self.changed()

    def do_jobs(self) -> None:
        """Do what was asked to be done between two pictures."""
        while self.jobs:
            self.jobs.pop(0)()

    def keep(self, files: dict[str, bytes]) -> str:
        """Keep files where the host keeps them, else in `folder`; return what to tell where they are."""
        return self.host.keep(self.folder, files) if self.host else keep_in(self.folder, files)

    # ---- pictures ------------------------------------------------------------------------------------------------

    def due(self, now: float) -> float:
        """Return in how many seconds there is something to do; infinity: only after an event."""
        if self._outdated or self._uncovered or self.jobs or self._moves():
            return 0.0
        waits = [self._message_ends - now, self.controls.shift_due - now]
        if self._stage < len(self._stages()) and not self.paused:
            waits.append(self._still_since + REST_SECONDS - now)
        return max(0.0, min(waits))

    def frame(self, now: float) -> Picture | None:
        """Make the next picture if there is to be one.

        Returns
        -------
        (height, width, 4) uint8 RGBA of the canvas' size, or what the presenter leaves on a GPU; it is good until the
        next but one is made. None: the last one is still right.
        """
        seconds = min(now - self._last, _LONGEST_STEP) if self._last is not None and self._moves() else 0.0
        self._last = self.now = now
        self._interrupted = False
        self.controls.step(now)
        self.do_jobs()
        if self.message and now >= self._message_ends:
            self.message, self._message_ends = None, math.inf
            self.uncover()
        if self._advance(seconds) or self._outdated:
            self._changed, self._still_since, self._stage = self._tell_of_compiling(), now, 0
            if not self._changed:
                self._render_moving()
        elif self.due(now) == 0.0 and not self._uncovered:
            if not self._refine():
                return None
        elif not self._uncovered:
            return None
        self._uncovered = False
        return self.presenter.compose(self)

    def _tell_of_failure(self, failure: str) -> None:
        """Have it said after the picture at work that the CPU took over, whose frames take another time."""
        self.jobs += [self.governor.forget, lambda: self.say(f"{failure}; the CPU goes on", _FAILURE_SECONDS)]

    def _tell_of_compiling(self) -> bool:
        """Return whether a picture that says so goes first: the next one waits for its kernel, for a second or two."""
        if self.message == _COMPILING:  # was shown
            self.message, self._message_ends = None, math.inf
        elif self.presenter.size == self.size and not self.renderer.is_ready(self.samples, self.debug_view):
            self.say(_COMPILING)
            return True
        return False

    @property
    def at_rest(self) -> bool:
        """Whether the picture is as good as it gets."""
        return self.due(self.now) == math.inf

    @property
    def _outdated(self) -> bool:
        """Whether the picture must be made anew; while paused, only for another canvas."""
        return self._changed and (not self.paused or self.presenter.size != self.size)

    def _moves(self) -> bool:
        if self.paused:
            return False
        return self.motion.moving or (self.time_runs and any(light.motion for light in self.scene.lights))

    def _advance(self, seconds: float) -> bool:
        """Let time pass; return whether anything moved."""
        if not self._moves():
            return False
        if self.motion.moving:
            self.pose = self.motion.step(self.pose, seconds)
        if self.time_runs:
            self.time += seconds
        return True

    def _stages(self) -> list[Samples]:
        """Return the samples of the pictures that follow one another at rest, all at full size."""
        if self.debug_view:
            return [1]
        finer = [2] if self.samples == 1 else []
        last: list[Samples] = [FINEST_SAMPLES] if self.samples == "adaptive" or self.samples < FINEST_SAMPLES else []
        return [self.samples, *finer, *last]

    def _render_moving(self) -> None:
        clock = self.presenter.clock
        start = clock()
        self.rendered_size = self.governor.size(self.size)
        self._render(self.rendered_size, self.samples)
        end = clock()
        self.frame_seconds = end - start
        self.governor.add(end - start, end)
        self.times.add(end - start)

    def _refine(self) -> bool:
        """Render the next picture at rest; return whether it was finished."""
        stages = self._stages()
        samples = stages[self._stage]
        if self._stage == 0 and self.rendered_size == self.size and self.film_samples == samples and len(stages) > 1:
            self._stage = 1  # it was rendered at full size all along
            samples = stages[1]
        self._refining = True
        start = self.presenter.clock()
        try:
            if self._interrupted:
                return False
            self._render(self.size, samples, self._stop_if_interrupted)
        except RenderCancelled:
            return False
        finally:
            self._refining = False
        end = self.presenter.clock()
        self.frame_seconds = end - start
        if samples == self.samples:
            self.governor.learn(end - start, end)
        self.rendered_size = self.size
        self._stage += 1
        return True

    def _stop_if_interrupted(self, stage: str, share: float) -> None:
        if self._interrupted:
            raise RenderCancelled

    def _render(self, size: tuple[int, int], samples: Samples, progress: Progress | None = None) -> None:
        """Render a picture of a size into the presenter."""
        self._aim(size)
        self.scene.settings.samples = samples
        if self.debug_view:
            self.presenter.show(self.renderer.render_debug(self.debug_view, self.time).image(), self.size)
            self.film = Film(np.zeros((1, 1, 4), np.float32))
        else:
            film = self.renderer.render(self.time, progress, self._films.pop(size, None))
            self._films = {size: film} if len(self._films) > 2 else {**self._films, size: film}
            self.film = film
            self.presenter.develop(film, self.scene.settings, self.size)
        self.film_samples = samples

    def _aim(self, size: tuple[int, int]) -> None:
        """Have the scene seen as the pose says, in a picture of that size."""
        self.scene.settings.width, self.scene.settings.height = size
        self.scene.camera = self.pose.camera()

    def _camera(self) -> Camera:
        """Return the scene's own camera, or one that frames it on the canvas."""
        settings = self.scene.settings
        settings.width, settings.height = self.size
        return self.scene.camera_or_framing()
