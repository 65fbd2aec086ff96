"""How long the first picture takes: whole processes, with kernels to compile and without."""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from glimt.bench.frame_scenes import ROWS
from glimt.bench.measure import Tell, median
from glimt.errors import GlimtError

_REPEATS = 5
_MOST_SECONDS = 600.0
_IMPORT = "import time; start = time.perf_counter(); import glimt; print(time.perf_counter() - start)"


def measure_first_image(scene: Path, tell: Tell = lambda text: None) -> dict[str, float]:
    """Return seconds of `glimt render` on an empty kernel cache (`cold_s`) and after that (`warm_s`, median of 5).

    The picture is that of the first row; both are from the start of the process to its end, the picture written.
    `import_ms` is `import glimt` in a fresh interpreter, the median of 5.
    """
    row = ROWS["room"]
    tell("first image: an empty kernel cache, then a filled one")
    with tempfile.TemporaryDirectory(prefix="glimt-bench-") as folder:
        environment = os.environ | {"GLIMT_CACHE_DIR": str(Path(folder) / "cache")}
        command = ["-m", "glimt", "render", str(scene), "--size", f"{row.size[0]}x{row.size[1]}", "--samples",
                   str(row.samples), "--bounces", str(row.bounces), "--output", str(Path(folder) / "picture.png")]
        cold = _run(command, environment)[0]
        warm = median([_run(command, environment)[0] for _ in range(_REPEATS)])
        imports = median([float(_run(["-c", _IMPORT], environment)[1]) for _ in range(_REPEATS)])
    return {"cold_s": cold, "warm_s": warm, "import_ms": 1e3 * imports}


def _run(arguments: list[str], environment: dict[str, str]) -> tuple[float, str]:
    """Run Python; return seconds and what it printed."""
    start = time.perf_counter()
    try:
        done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True,
                              timeout=_MOST_SECONDS, check=True)
    except subprocess.CalledProcessError as error:
        said = str(error.stderr).strip().splitlines() or [f"exit code {error.returncode}"]
        raise GlimtError(f"first image: `python {' '.join(arguments)}` failed: {said[-1]}") from None
    except subprocess.TimeoutExpired:
        raise GlimtError(f"first image: `python {' '.join(arguments)}` took more than {_MOST_SECONDS:.0f} s") from None
    return time.perf_counter() - start, done.stdout
