"""House rules: which package may import which, and how long things may be."""

import ast
import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted((ROOT / "src").rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("*.py"))


def _name(path):
    return path.relative_to(ROOT).as_posix()


def test_imports_only_point_back():
    pytest.importorskip("importlinter")
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as lint; lint()", "--no-cache"]
    result = subprocess.run(command, cwd=ROOT, env={**os.environ, "COLUMNS": "120"}, capture_output=True, text=True,
                            timeout=60, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert " 0 broken" in result.stdout


@pytest.mark.parametrize("path", [*SOURCES, *TESTS], ids=_name)
def test_files_and_functions_are_short(path):
    text = path.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 400
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            assert node.end_lineno - node.lineno < 80, node.name


@pytest.mark.parametrize("path", SOURCES, ids=_name)
def test_every_module_says_what_it_is(path):
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))


def test_importing_any_module_of_the_package_works_alone():
    """No module relies on another having been imported before it."""
    names = [_name(path)[4:-3].replace("/", ".").removesuffix(".__init__") for path in SOURCES]
    names = [name for name in names if not name.endswith("__main__")]
    light = [name for name in names if name.startswith(("glimt.scene", "glimt.errors", "glimt.linalg", "glimt.layout"))]
    with contextlib.ExitStack() as stack:
        runs = [stack.enter_context(subprocess.Popen([sys.executable, "-c", f"import {name}"])) for name in light]
        assert [run.wait(60) for run in runs] == [0] * len(runs)
