"""Results as Markdown tables, and the place in a document where a table stands."""

from collections.abc import Callable
from pathlib import Path

from glimt.bench.results import AT_ONCE, Result
from glimt.errors import GlimtError


def table(result: Result) -> str:
    """Return a Markdown table of any result, with the machine under it."""
    machine = result["machine"]
    where = (f"{machine['processor']} ({', '.join(machine['features'])}), {machine['lanes']} lanes, "
             f"{machine['cores']} cores; Python {machine['python']}, Numba {machine['numba']}, "
             f"glimt {machine['glimt']}.")
    missing = [f"Left out: {entry['row']} ({entry['reason']})." for entry in result.get("missing", [])]
    return "\n".join([*_TABLES[result["benchmark"]](result), *missing, "", where])


def _rays(result: Result) -> list[str]:
    lines = ["| mesh | rays | threads | glimt, Mrays/s | without clearances | Embree's best | ratio "
             "| differing per million |", "|---|---|---|---|---|---|---|---|"]
    lines += [f"| {row['mesh']} {row['triangles']:,} | {row['kind']} | {row['threads']} | "
              f"{row['mrays']['glimt']:.1f} | {_rate(row['mrays'].get(AT_ONCE))} | "
              f"{row['mrays'][row['best']]:.1f} ({row['best']}) | "
              f"{row['ratio']:.2f} | {row['differing']:.1f} |" for row in result["rows"]]
    return lines


def _rate(mrays: float | None) -> str:
    return "" if mrays is None else f"{mrays:.1f}"


def _frames(result: Result) -> list[str]:
    lines = ["| frame | threads | ms (p10–p90) | Mrays | Mrays/s | Embree, just the rays, ms | "
             "ratio (of processor time) | speedup (Embree's) | differing per million |",
             "|---|---|---|---|---|---|---|---|---|"]
    ways = []
    for row in result["rows"]:
        ms, rays = row["frame_ms"], row["rays"]
        differing = sum(row["differing"][kind] * entry["rays"] for kind, entry in row["yardstick"].items())
        differing /= sum(entry["rays"] for entry in row["yardstick"].values())
        lines.append(
            f"| {row['title']}, {row['size'][0]}×{row['size'][1]}, {row['samples'] ** 2} per pixel, {row['bounces']} "
            f"bounces | {row['threads']} | {ms['median']:.1f} ({ms['p10']:.1f}–{ms['p90']:.1f}) | "
            f"{' + '.join(f'{rays[kind] / 1e6:.2f}' for kind in ('primary', 'shadow', 'mirror'))} | {row['mrays']:.1f} "
            f"| {row['embree_ms']['median']:.1f} | {row['ratio']:.2f} ({row['processor_ratio']:.2f}) | "
            f"{row['speedup']:.2f} ({row['embree_speedup']:.2f}) | {differing:.1f} |")
        way = f"{row['row']}: " + ", ".join(f"{kind} {entry['configuration']}" for kind, entry in
                                            row["yardstick"].items())
        ways += [way] if way not in ways else []
    lines += ["", "Mrays: primary + shadow + mirror rays of a frame. Ratio: the frame's time through Embree's for just "
              f"those rays. Embree's best: {'; '.join(ways)}."]
    first = result.get("first_image")
    if first:
        lines += ["", f"First image of the paper's scene, a whole process: {first['cold_s']:.1f} s with no kernels "
                  f"compiled, {first['warm_s']:.2f} s afterwards; `import glimt` takes {first['import_ms']:.1f} ms."]
    return lines


def _growth(result: Result) -> list[str]:
    lines = ["| series | setting | ms (p10–p90) | through the first |", "|---|---|---|---|"]
    for row in result["rows"]:
        ms = row["frame_ms"]
        lines.append(f"| {row['series']} | {row['count']:,} | {ms['median']:.1f} ({ms['p10']:.1f}–{ms['p90']:.1f}) | "
                     f"{row['ratio']:.2f} |")
    fits = [f"{name} {fit['ms']:+.2f} ms {'each' if fit['per'] == 'each' else 'for ten times as many'} (R² "
            f"{fit['r2']:.2f})" for name, fit in result["fits"].items()]
    return [*lines, "", f"Least squares: {', '.join(fits)}. Mesh: {result['mesh']}, as instances with "
            f"{result['instance_triangles']:,} triangles. Threads: {result['threads']}."]


def _flight(result: Result) -> list[str]:
    lines = ["| canvas | bounces, lights | budget, ms | frames a second | ms: p50, p95, longest | within 1.5 budgets | "
             "rendered side | changes of size, most in a second |", "|---|---|---|---|---|---|---|---|"]
    lines += [f"| {row['size'].replace('x', '×')} | {row['bounces']}, {row['lights']} | {row['budget_ms']:.0f} | "
              f"{row['fps']:.0f} | {row['p50_ms']:.1f}, {row['p95_ms']:.1f}, {row['longest_ms']:.1f} | "
              f"{100 * row['in_time']:.1f} % | {100 * row['scale']:.0f} % | {row['changes']}, "
              f"{row['most_changes_a_second']} |" for row in result["rows"]]
    return [*lines, "", f"{result['scene']}, {result['rows'][0]['seconds']:g} s with {result['rows'][0]['threads']} "
            "threads; a frame is timed from events to the finished picture.", *_stage_lines(result)]


def _stage_lines(result: Result) -> list[str]:
    """Return what each stage took, where it was timed."""
    return [line for row in result["rows"] if row.get("stage_ms") for line in (
        "", f"{row['engine']}, ms of a picture: " + ", ".join(
            f"{stage.replace('_', ' ')} {taken:.2f}" for stage, taken in row["stage_ms"].items()) + ".")]


_TABLES: dict[str, Callable[[Result], list[str]]] = {"rays": _rays, "frames": _frames, "growth": _growth,
                                                     "flight": _flight}


def write_into(path: Path, name: str, text: str) -> None:
    """Put a text between the lines ``<!-- name -->`` and ``<!-- /name -->`` of a file."""
    first, last = f"<!-- {name} -->", f"<!-- /{name} -->"
    try:
        document = path.read_text(encoding="utf-8")
        before, opening, rest = document.partition(first)
        _, closing, after = rest.partition(last)
        if not opening or not closing:
            raise GlimtError(f"{path}: has no lines {first} and {last} for the table to stand between; add them")
        path.write_text(f"{before}{first}\n\n{text}\n\n{last}{after}", encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise GlimtError(f"{path}: the table cannot be written into it: {error}") from None
