"""A whole study: figure by figure, each kept as soon as it is done."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from glimt.engines import choose_engine, get_engine
from glimt.errors import GlimtError
from glimt.scene.scene import Scene
from glimt.study import laws, results
from glimt.study.experiments import FIGURES, SIDE, Curves, Study, base_of
from glimt.study.figures import empty_figure, make_figure
from glimt.study.fingerprint import load_scene, this_machine
from glimt.study.measuring import Frames, measure_frames
from glimt.study.results import FILE_NAME, Figure, StudyResult

Tell = Callable[[str, float, float], None]
"""Is told what is being done, how far all of it is (0 to 1), and the seconds that are left."""

Preparing = Callable[[str, float], None]
"""Is told about compiling."""

SECONDS, QUICK_SECONDS = 25.0, 2.0
"""What a figure may measure, the making of its scenes aside."""


class Order(NamedTuple):
    """What is asked for.

    Parameters
    ----------
    seconds : float
        For measuring each figure, which has five rounds at least.
    resume : bool
        Whether to go on with what the folder holds.
    overwrite : bool
        Whether what the folder holds may go.
    command : str
        As it was typed, for the result.
    """

    scene: Path
    folder: Path
    figures: list[int]
    engine: str = "auto"
    threads: int | None = None
    quick: bool = False
    brute_force: bool = False
    seconds: float = SECONDS
    resume: bool = False
    overwrite: bool = False
    command: str = ""


def run(order: Order, tell: Tell = lambda text, share, left: None,
        preparing: Preparing = lambda text, share: None) -> tuple[StudyResult, bool]:
    """Measure the figures that are wanted, and return the result with whether it came to its end.

    `tell` is told how far it is, `preparing` about compiling. The result is written to the folder after each figure,
    and when Ctrl-C ends one early, with the rounds that it has.

    Raises
    ------
    GlimtError
        When the folder holds another study, or one that cannot be gone on with.
    """
    scene, facts = load_scene(order.scene)
    choice = choose_engine(order.engine)
    get_engine(choice.engine, order.threads).prepare(preparing)
    adapter = choice.reason if choice.engine == "gpu" else None
    base = base_of(scene)
    result = StudyResult(
        study=results.VERSION, command=order.command, created=datetime.now(UTC).isoformat(timespec="seconds"),
        engine=choice.engine, quick=order.quick, brute_force=order.brute_force, confidence=laws.CONFIDENCE,
        base=_describe(base), scene=facts, machine=this_machine(order.threads, adapter), figures=[])
    path = order.folder / FILE_NAME
    result.figures = _kept(path, result, order)
    return result, _measure_all(order, Study(base, choice.engine, order.quick, order.brute_force), result, path, tell)


def _measure_all(order: Order, study: Study, result: StudyResult, path: Path, tell: Tell) -> bool:
    """Add the figures that are missing; return False when Ctrl-C came."""
    done = {figure.number for figure in result.figures if figure.complete}
    wanted = [number for number in order.figures if number not in done]
    for place, number in enumerate(wanted):
        def progress(part: float, place: int = place, number: int = number) -> None:
            whole = (place + part) / len(wanted)
            tell(f"figure {number}: {FIGURES[number].title.lower()}", whole, (1 - whole) * len(wanted) * order.seconds)

        progress(0.0)
        try:
            figure = _measure(number, study, order.threads, order.seconds, progress)
        except KeyboardInterrupt:
            return False
        result.figures = sorted([*(each for each in result.figures if each.number != number), figure],
                                key=lambda each: each.number)
        results.write(path, result)
        if not figure.complete:
            return False
    return True


def _measure(number: int, study: Study, threads: int | None, seconds: float,
             progress: Callable[[float], None]) -> Figure:
    """Return one figure; what this scene or machine cannot have is told in its notes."""
    runs: list[Frames] = []
    notes, possible = [], Curves()
    if study.engine not in FIGURES[number].engines:
        return empty_figure(number, [f"the {study.engine.upper()} engine has nothing to vary here"])
    try:
        curves = FIGURES[number].settings(study)
    except GlimtError as error:
        return empty_figure(number, [str(error)])
    for name, settings in curves.items():
        for setting in settings:
            try:
                runs.append(Frames(setting, study.engine, threads))
            except GlimtError as error:  # beyond a limit of this machine's
                notes.append(f"{name}, {setting.label}: {error}")
            else:
                possible.setdefault(name, []).append(setting)
    if not runs:
        return empty_figure(number, notes)
    return make_figure(number, possible, measure_frames(runs, seconds, progress), notes)


def _describe(base: Scene) -> str:
    lights = [type(light).__name__.removesuffix("Light").lower() for light in base.lights]
    said = " and ".join(f"{lights.count(kind)} {kind}" for kind in dict.fromkeys(lights)) or "none"
    return (f"{SIDE}×{SIDE} pixels, one sample each, no bounces, lights: {said}, "
            f"{3 * base.placed_triangles():,} vertices, {len(base.spheres())} sphere{'s' * (len(base.spheres()) != 1)}")


def _kept(path: Path, result: StudyResult, order: Order) -> list[Figure]:
    """Return the figures to go on with; refuse to write over a study unless that is wanted."""
    if not path.exists() or order.overwrite:
        return []
    if not order.resume:
        raise GlimtError(f"{path}: is there already; give --resume to go on with it, --overwrite to begin anew, or "
                         "another folder with -o")
    before = results.read(path)
    for name in ("engine", "quick", "brute_force"):
        if getattr(before, name) != getattr(result, name):
            raise GlimtError(f"{path}: was measured with {name.replace('_', ' ')} {getattr(before, name)}, not "
                             f"{getattr(result, name)}; give the same options to go on, or another folder with -o")
    if before.scene.sha256 != result.scene.sha256:
        raise GlimtError(f"{path}: is about another scene, or its files have changed; give another folder with -o")
    changed = [name for name in ("processor", "cores", "threads", "lanes", "adapter", "versions")
               if getattr(before.machine, name) != getattr(result.machine, name)]
    if changed:
        raise GlimtError(f"{path}: was measured with other {' and '.join(changed)}; give another folder with -o")
    result.created, result.command = before.created, before.command
    return before.figures
