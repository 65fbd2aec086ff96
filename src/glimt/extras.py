"""Modules of ours whose packages are installed only where they are wanted: the extras of pyproject.toml."""

import importlib
from typing import Any

from glimt.errors import GlimtError


def need(module: str, extra: str) -> Any:
    """Return a module of ours that needs packages of an extra; an error that names it when they are not there."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("glimt"):
            raise
        raise GlimtError(f"this needs the package {error.name}: pip install 'glimt[{extra}]'") from None
