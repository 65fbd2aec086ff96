"""What a study leaves in its folder besides the numbers: the report and the figures."""

from pathlib import Path

from glimt.errors import GlimtError
from glimt.study import plots, report
from glimt.study.results import StudyResult

REPORT = "report.html"


def write_report(folder: Path, result: StudyResult) -> Path:
    """Write the report and a PNG image of each figure; return the report's path."""
    images = {f"figure-{figure.number}-{figure.name}.png": plots.png([("", figure)])
              for figure in result.figures if figure.series}
    return _write(folder, report.report(result), images)


def write_comparison(folder: Path, named: list[tuple[str, StudyResult]]) -> Path:
    """Write a report of two studies and a PNG image of each figure that both have; return the report's path."""
    (first, before), (second, after) = named
    images = {}
    for figure in before.figures:
        other = after.figure(figure.number)
        if other is not None and figure.series and other.series:
            images[f"figure-{figure.number}-{figure.name}.png"] = plots.png([(first, figure), (second, other)])
    return _write(folder, report.comparison(named), images)


def names_of(before: Path, after: Path) -> tuple[str, str]:
    """Return what tells two results apart: their folders or their file names, whichever differ."""
    for first, second in ((before.stem, after.stem), (before.absolute().parent.name, after.absolute().parent.name)):
        if first != second:
            return first, second
    return str(before), f"{after} (again)" if before == after else str(after)


def _write(folder: Path, page: str, images: dict[str, bytes]) -> Path:
    path = folder / REPORT
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in images.items():
            (folder / name).write_bytes(data)
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise GlimtError(f"{folder}: cannot be written to: {error.strerror}") from None
    return path
