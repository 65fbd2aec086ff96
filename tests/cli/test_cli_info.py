"""`glimt info`, `--version` and help."""

import json
import platform

import glimt as api
from glimt import kernel
from glimt.engines.gpu import adapters
from glimt.errors import GlimtError


def test_machine(glimt):
    end = glimt("info")
    assert (end.code, end.err) == (0, "")
    lines = {line[:18].strip(): line[18:] for line in end.out.splitlines()}
    assert lines["glimt"] == api.__version__
    assert lines["python"] == platform.python_version()
    assert lines["lanes"] == str(kernel.host_lanes())
    assert set(lines["features"].split()) <= kernel.host_features()
    assert lines["cache folder"] == str(kernel.cache_folder())
    assert lines["kernels compiled"] in ("yes", "no")


def test_machine_as_json(glimt, monkeypatch, tmp_path):
    folder = tmp_path / "kernels" / "key"
    folder.mkdir(parents=True)
    (folder / "a.nbc").write_bytes(b"12345")
    monkeypatch.setattr(kernel, "cache_folder", lambda: folder)
    facts = json.loads(glimt("info", "--json").out)
    assert facts["cache_bytes"] == 5
    assert facts["threads"] >= 1
    assert facts["lanes"] in (4, 8, 16)


def test_what_would_render(glimt, monkeypatch):
    monkeypatch.setattr(adapters, "list_adapters", lambda: [adapters.AdapterInfo("Old Card", "discrete", "Vulkan"),
                                                            adapters.AdapterInfo("Chip", "integrated", "Vulkan")])
    facts = json.loads(glimt("info", "--json").out)
    assert facts["engine"] in ("cpu", "gpu")
    assert facts["reason"]
    assert facts["adapters"] == ["Old Card", "Chip"]
    text = glimt("info", "--engine", "cpu").out
    assert "engine            cpu\nreason            asked for\nadapters          Old Card, Chip\n" in text
    usage = glimt("info", "--engine", "tpu")
    assert usage.code == 2
    assert "'tpu' is none of auto, cpu, gpu" in usage.err


def test_no_adapters_without_wgpu(glimt, monkeypatch):
    def fail():
        raise GlimtError("wgpu cannot be loaded")
    monkeypatch.setattr(adapters, "list_adapters", fail)
    assert json.loads(glimt("info", "--json").out)["adapters"] == []


def test_scene(glimt, tmp_path):
    (tmp_path / "two.toml").write_text(
        "[[mesh]]\nname = 'leaf'\npositions = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]\ntriangles = [[0,1,2],[0,1,3]]\n"
        + "[[instance]]\nmesh = 'leaf'\n" * 3 + "[[sphere]]\ncenter = [0,0,0]\nradius = 1\n")
    end = glimt("info", "two.toml", "--json")
    facts = json.loads(end.out)
    assert (facts["triangles"], facts["placed_triangles"], facts["meshes"], facts["instances"]) == (2, 6, 1, 3)
    assert (facts["spheres"], facts["lights"], facts["textures"]) == (1, 0, 0)
    assert facts["memory_bytes"] > 0
    assert facts["warnings"] == 1
    assert end.err.startswith("warning: two.toml: no lights")
    text = glimt("info", "two.toml").out
    assert "placed triangles  6\n" in text
    assert " MiB\n" in text


def test_a_scene_that_is_not_there(glimt):
    assert glimt("info", "nix.obj") == (1, "", "error: nix.obj: no such file\n")


def test_version_and_help(glimt):
    assert glimt("--version") == (0, f"glimt {api.__version__}\n", "")
    for arguments in (["--help"], ["render", "-h"], ["info", "--help"]):
        end = glimt(*arguments)
        assert end.code == 0
        assert "Usage: glimt" in end.out
