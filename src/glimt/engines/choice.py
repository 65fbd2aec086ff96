"""Which engine is taken, and why."""

import os
from typing import Literal, NamedTuple

from glimt.engines.gpu.adapters import choose_adapter, is_installed, list_adapters
from glimt.errors import GlimtError

ENGINES = ("auto", "cpu", "gpu")


class Choice(NamedTuple):
    """An engine, and the reason as a person would be told."""

    engine: Literal["cpu", "gpu"]
    reason: str


def choose_engine(name: str = "auto") -> Choice:
    """Return which engine a name stands for.

    "auto" is the GPU where wgpu is installed and a real one is found, else the CPU. It costs nothing without wgpu; with
    it the drivers are asked, which takes some tenths of a second, once in a process.

    Raises
    ------
    GlimtError
        For any other name, and where "gpu" finds nothing to run on.
    """
    if name not in ENGINES:
        raise GlimtError(f"there is no engine {name!r}; expected 'auto', 'cpu' or 'gpu'")
    if name == "cpu":
        return Choice("cpu", "asked for")
    try:
        if name == "auto" and not is_installed():
            return Choice("cpu", "the package wgpu is not installed: pip install 'glimt[gpu]'")
        adapter = choose_adapter(list_adapters(), os.environ.get("GLIMT_GPU", ""))
    except GlimtError as error:
        if name == "gpu":
            raise
        return Choice("cpu", str(error))
    if name == "auto" and adapter.kind == "software":
        return Choice("cpu", f"{adapter.summary} would use the CPU as well, and slower; only 'gpu' takes it")
    return Choice("gpu", adapter.summary)
