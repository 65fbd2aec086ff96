"""What `import glimt` costs: nearly nothing."""

import subprocess
import sys

HEAVY = {"numpy", "numba", "llvmlite", "pydantic", "PIL", "typer", "rich", "platformdirs", "click", "tkinter"}


def _modules(code):
    """Return the modules that running `code` in a fresh interpreter adds."""
    script = f"import sys; before = set(sys.modules)\n{code}\nprint(*sorted(set(sys.modules) - before))"
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True)
    return set(result.stdout.split())


def test_import_is_light():
    added = _modules("import glimt")
    assert len(added) < 50
    assert not added & HEAVY
    assert {name for name in added if name.startswith("glimt")} == {"glimt"}


def test_scene_objects_need_numpy_only():
    added = _modules("from glimt import Camera, GlimtError, Material, Mesh, Scene, Sphere")
    assert "numpy" in added
    assert not added & (HEAVY - {"numpy"})


def test_rendering_needs_no_file_formats():
    added = _modules("from glimt import Renderer, Scene; import glimt.engines.cpu.engine")
    assert "numba" in added
    assert not added & {"PIL", "pydantic", "typer", "rich", "click", "tkinter"}
    assert not any(name.startswith(("glimt.io", "glimt.cli")) for name in added)
