"""Results of a study as a JSON file, and its schema."""

import json
import os
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from glimt.errors import GlimtError
from glimt.study.laws import LawName

VERSION = 1
"""Goes up when a file of before could be misread. Files of versions before stay readable: `_UPGRADES` says how."""
_UPGRADES: dict[int, Any] = {}
"""By version, what turns the contents of such a file into those of the next version."""
FILE_NAME = "results.json"


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Number(_Model):
    """A number and the interval that holds it at the study's confidence."""

    value: float
    lo: float
    hi: float


class Law(_Model):
    """A law through a series' times in milliseconds, with its numbers."""

    law: LawName
    numbers: dict[str, Number]
    r2: float = Field(description="share of the variance of the times that the law explains")
    deviation: float = Field(description="root mean square of the rest, as a share of the time")


class Rays(_Model):
    """Rays of one frame by kind, counted by the engine."""

    primary: int
    shadow: int
    mirror: int

    @property
    def total(self) -> int:
        """All rays."""
        return self.primary + self.shadow + self.mirror


class Point(_Model):
    """One setting of a series."""

    x: float = Field(description="the value that is varied")
    label: str = Field(description="the setting in words")
    ms: Number = Field(description="median frame time, rounds steadied against the drift of the machine")
    times_ms: list[list[float]] = Field(description="every frame that was timed, by round, as measured")
    rays: Rays
    stages_ms: dict[str, float] = Field(default_factory=dict, description="time of each stage, where it is measured")

    @property
    def rays_per_second(self) -> float:
        """Rays of a frame through its median time."""
        return 1e3 * self.rays.total / self.ms.value


class Series(_Model):
    """Settings along one variable, and the law of their times."""

    name: str
    brute_force: bool = Field(default=False, description="whether every ray tested everything, without trees")
    points: list[Point]
    laws: list[Law] = Field(default_factory=list, description="all that were tried; none for settings without an order")
    law: str = Field(default="", description="the one that tells the times best")
    rays_law: Law | None = Field(default=None, description="a line through time against counted rays")
    verdict: str = Field(default="", description="what follows, in a sentence")

    def fitted(self, law: str) -> Law | None:
        """Return a law that was tried."""
        return next((each for each in self.laws if each.law == law), None)


class Figure(_Model):
    """One experiment."""

    number: int
    name: str
    title: str
    x_title: str
    kind: Literal["curve", "bars", "stages"]
    log: bool = Field(description="whether it is drawn with logarithmic axes")
    paper: str = Field(description="what the paper found; empty where it has no such figure")
    series: list[Series]
    rounds: int = Field(description="how often all settings were timed, in turn")
    complete: bool = Field(description="false when it was interrupted")
    notes: list[str] = Field(default_factory=list, description="what was left out, and why")


class SceneFacts(_Model):
    """What was rendered."""

    name: str
    sha256: str = Field(description="of all files that were read for it")
    triangles: int
    spheres: int
    lights: int


class Machine(_Model):
    """What the numbers depend on."""

    processor: str
    features: list[str]
    lanes: int
    cores: int
    threads: int
    clock_mhz: float | None
    adapter: str | None = Field(description="the GPU and its driver, when that rendered")
    system: str
    versions: dict[str, str]


class StudyResult(_Model):
    """All experiments of one run."""

    study: int = Field(description="version of this format")
    command: str
    created: str = Field(description="ISO 8601, UTC")
    engine: Literal["cpu", "gpu"]
    quick: bool
    brute_force: bool
    confidence: float
    base: str = Field(description="the configuration around which one thing at a time is varied")
    scene: SceneFacts
    machine: Machine
    figures: list[Figure]

    def figure(self, number: int) -> Figure | None:
        """Return a figure by its number."""
        return next((each for each in self.figures if each.number == number), None)


def write(path: Path, result: StudyResult) -> None:
    """Write a result; a file of that name is replaced only once all is written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(".part")
        unfinished.write_text(result.model_dump_json(indent=1) + "\n", encoding="utf-8")
        os.replace(unfinished, path)
    except OSError as error:
        raise GlimtError(f"{path}: cannot be written: {error.strerror}") from None


def read(path: Path) -> StudyResult:
    """Read a result, of this version or one before.

    Raises
    ------
    GlimtError
        For what is no result, and for one of a version that cannot be read, saying why.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise GlimtError(f"{path}: cannot be read as a result of a study: {error}") from None
    version = data.get("study") if isinstance(data, dict) else None
    if not isinstance(version, int):
        raise GlimtError(f"{path}: is no result of `glimt study`")
    if version > VERSION:
        raise GlimtError(f"{path}: has format {version}, this glimt reads up to {VERSION}; upgrade glimt")
    while version < VERSION:
        if version not in _UPGRADES:
            raise GlimtError(f"{path}: has format {version}, which this glimt no longer reads; run the study again")
        data, version = _UPGRADES[version](data), version + 1
    try:
        return StudyResult.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        raise GlimtError(f"{path}: is no result of `glimt study`: {place}: {first['msg']}") from None


def schema() -> str:
    """Return the JSON schema of result files."""
    return json.dumps(StudyResult.model_json_schema(), indent=1) + "\n"
