"""The commands that time frames, on small scenes: what they write, and what they say about missing files."""

import functools
import json
import os
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

pytest.importorskip("embreex", reason="Embree, the yardstick, is not installed")

import closed_meshes
from glimt.bench import first_image, frame_scenes, mesh_sizes, steady
from glimt.bench.measure import Blocks, interleave_blocks, milliseconds, processor_quotient, quotient
from glimt.bench.steady import orbited
from glimt.cli.app import app
from glimt.errors import GlimtError
from glimt.io import load
from glimt.renderer import Renderer
from glimt.scene.camera import Camera

SCENE = """
[render]
size = [24, 16]
[[material]]
name = "silver"
reflectivity = 0.5
[[sphere]]
center = [0, 0, 0]
radius = 1
material = "silver"
[[sphere]]
center = [2.1, 0, 0]
radius = 1
[[light]]
type = "point"
position = [3, 3, 3]
radius = 4
[[light]]
type = "directional"
direction = [0, -1, -1]
"""


def write_obj(path, mesh):
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.positions.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles + 1).tolist()]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Stand in a folder with a scene and models of the right names."""
    (tmp_path / "room.toml").write_text(SCENE)
    for name in (frame_scenes.BUNNY, frame_scenes.ARMADILLO, frame_scenes.NEFERTITI):
        write_obj(tmp_path / "models" / name.split(".")[0] / name, closed_meshes.icosphere(2, roughness=0.1))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def bench(*arguments):
    """Run a command; return (exit code, stdout, stderr)."""
    done = CliRunner().invoke(app, ["bench", *map(str, arguments)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, done.stdout, done.stderr


QUICK = ("--quick", "--rounds", 1, "--frames", 1, "--json", "result.json")


def test_frames_of_every_row(folder):
    (folder / "notes.md").write_text("<!-- frames -->\n<!-- /frames -->\n")
    code, out, err = bench("frames", *QUICK, "--scene", "room.toml", "--models", "models", "--threads", 1,
                           "--threads", 2, "--no-first-image", "--into", "notes.md")
    assert code == 0, err
    result = json.loads((folder / "result.json").read_text())
    assert (result["benchmark"], result["version"], result["missing"]) == ("frames", 1, [])
    assert [(row["row"], row["threads"]) for row in result["rows"]] == [
        (name, threads) for name in frame_scenes.ROWS for threads in (1, 2)]
    for row in result["rows"]:
        width, height = row["size"]
        assert row["rays"]["primary"] == width * height * row["samples"] ** 2
        assert row["rays"]["primary"] == row["yardstick"]["primary"]["rays"]
        assert row["lights"] == 2
        assert (row["rays"]["mirror"] > 0) == ("mirror" in row["yardstick"]) == (row["bounces"] > 0)
        # Each is one block of one frame, so that the ratio of the two is that of the medians.
        assert row["ratio"] == pytest.approx(row["frame_ms"]["median"] / row["embree_ms"]["median"])
        assert row["processor_ratio"] > 0
        for kind, per_million in row["differing"].items():
            assert per_million * row["yardstick"][kind]["rays"] <= 4e6, (row["row"], kind)  # rims of spheres
    assert {row["instances"] for row in result["rows"] if row["row"] == "instances"} == {1001}
    assert out.count("| 1,000 bunnies") == 2
    assert (folder / "notes.md").read_text() == f"<!-- frames -->\n\n{out}\n<!-- /frames -->\n"
    code, out, err = bench("compare", "result.json", "result.json")
    assert (code, out.count("+0 %")) == (0, 10), err


def test_rows_without_files_are_left_out_and_that_is_said(folder):
    (folder / "models" / "armadillo" / frame_scenes.ARMADILLO).unlink()
    code, out, err = bench("frames", *QUICK, "--rows", "room,statues", "--scene", "room.toml", "--models", "models",
                           "--threads", 1, "--no-first-image")
    assert code == 0, err
    result = json.loads((folder / "result.json").read_text())
    assert [row["row"] for row in result["rows"]] == ["room"]
    assert result["missing"] == [{"row": "statues", "reason": "armadillo.obj not found; not below models"}]
    assert "left out: statues: armadillo.obj not found" in err
    assert "Left out: statues" in out


def test_in_any_folder_the_example_is_there_and_models_are_asked_for(folder):
    code, out, err = bench("frames", *QUICK, "--rows", "room,statues,instances", "--threads", 1, "--no-first-image")
    assert code == 0, err
    result = json.loads((folder / "result.json").read_text())
    assert [(row["row"], row["spheres"] > 0) for row in result["rows"]] == [("room", True)]
    assert [entry["row"] for entry in result["missing"]] == ["statues", "instances"]
    for told in (err, out):
        assert "--models FOLDER" in told


@pytest.mark.parametrize(("arguments", "told"), [
    (["frames", "--rows", "room,hall"], "'hall'"), (["frames", "--models", "nowhere"], "nowhere: no such folder"),
    (["frames", "--scene", "nowhere.toml"], "nowhere.toml: no such file"),
    (["growth", "nowhere.obj"], "nowhere.obj"), (["growth", "--scene", "nowhere.toml", "ball.obj"], "nowhere.toml"),
    (["compare", "room.toml", "room.toml"], "room.toml: cannot be read as a result"),
])
def test_errors_name_what_is_wrong(folder, arguments, told):
    write_obj(folder / "ball.obj", closed_meshes.icosphere(0))
    code, _, err = bench(*arguments)
    assert code == 1
    assert told in err.splitlines()[-1]


def test_growth_of_every_series(folder):
    write_obj(folder / "ball.obj", closed_meshes.icosphere(3, roughness=0.1))
    code, out, err = bench("growth", "ball.obj", *QUICK, "--scene", "room.toml", "--size", 16)
    assert code == 0, err
    result = json.loads((folder / "result.json").read_text())
    counts = {name: [row["count"] for row in result["rows"] if row["series"] == name] for name in result["fits"]}
    assert counts["triangles"] == sorted(set(counts["triangles"]))
    assert counts["triangles"][-1] == 1280  # 5120 would be beyond what --quick allows
    assert counts["triangles"][0] == result["instance_triangles"] < 640
    assert counts["instances"] == [1, 9]
    assert counts["lights"][-1] == 16
    assert counts["bounces"][-1] == 10
    for fit in result["fits"].values():
        assert np.isfinite([fit["ms"], fit["at_first"], fit["r2"]]).all()
    assert out.count("| lights |") == len(counts["lights"])
    assert bench("compare", "result.json", "result.json")[0] == 0


def test_growth_is_that_of_the_example_where_no_scene_is_named(folder):
    write_obj(folder / "ball.obj", closed_meshes.icosphere(1))
    code, _, err = bench("growth", "ball.obj", *QUICK, "--size", 16)
    assert code == 0, err
    assert set(json.loads((folder / "result.json").read_text())["fits"]) == {"triangles", "instances", "lights",
                                                                             "bounces"}


def test_rays_of_a_subdivided_mesh(folder):
    write_obj(folder / "ball.obj", closed_meshes.icosphere(1))
    code, out, err = bench("rays", "ball.obj", "--size", 32, "--subdivide", 2, "--rounds", 1)
    assert (code, out.count("| ball 1,280 |")) == (0, 4), err


def test_subdividing_and_clustering_keep_the_shape():
    mesh = closed_meshes.icosphere(3)
    finer = mesh_sizes.subdivided(mesh)
    assert len(finer.triangles) == 4 * len(mesh.triangles)
    assert len(np.unique(finer.positions, axis=0)) == len(finer.positions)  # neighbours share their middles
    assert area(finer).sum() == pytest.approx(area(mesh).sum(), rel=1e-5)
    coarser = mesh_sizes.clustered(mesh, 8)
    assert 0 < len(coarser.triangles) < len(mesh.triangles) / 2
    assert area(coarser).min() > 0
    assert area(coarser).sum() == pytest.approx(area(mesh).sum(), rel=0.1)
    np.testing.assert_allclose(coarser.bounds(), mesh.bounds(), atol=0.25)


def area(mesh):
    """Return twice the area of each triangle, turned outwards: negative where it shows its inside."""
    a, b, c = np.moveaxis(mesh.positions[mesh.triangles].astype(np.float64), 1, 0)
    normals = np.cross(b - a, c - a)
    return np.linalg.norm(normals, axis=1) * np.sign((normals * (a + b + c)).sum(1))


def test_a_camera_goes_round_its_target():
    camera = Camera((1.0, 2.0, 5.0), (1.0, 2.0, 0.0))
    there = orbited(camera, 90)
    np.testing.assert_allclose(there.position, (6, 2, 0), atol=1e-12)
    assert (there.target, there.fov_deg) == (camera.target, camera.fov_deg)


def test_a_frame_swings_the_camera_but_does_not_look_for_its_place(folder, monkeypatch):
    seen = []

    def render(self, film=None):
        seen.append(self.scene.camera)
        return rendered(self, film=film)

    rendered = Renderer.render
    monkeypatch.setattr(Renderer, "render", render)
    frame = steady.SteadyFrames(load("room.toml"), 1, 4.0)
    monkeypatch.setattr(steady, "orbited", None)
    for _ in range(steady._FRAMES + 1):
        frame()
    first, swung = seen[1], seen[2:]
    assert swung[-1] is first  # round and round
    assert len({camera.position for camera in swung}) > steady._FRAMES / 4
    arms = [np.subtract(camera.position, camera.target) for camera in (first, *swung)]
    cosines = [float(arm @ arms[0] / (arms[0] @ arms[0])) for arm in arms]
    assert 3.5 < np.degrees(np.arccos(min(cosines))) <= 4  # the arm is not quite across the axis


def test_a_ratio_is_taken_within_rounds():
    quick, slow = Blocks([[1, 1, 9], [4, 4, 0]], 0.5), Blocks([[2, 2, 2], [8, 8, 8]], 2.0)
    assert quotient(quick, slow) == 0.5  # though the second round was four times as slow
    assert processor_quotient(slow, quick) == 4
    assert milliseconds(slow)["median"] == 5000


def test_blocks_take_turns():
    order = []
    runs = {name: functools.partial(order.append, name) for name in "ab"}
    blocks = interleave_blocks(runs, 2, 2)
    assert "".join(order) == "aaabbb" + "bbbaaa"  # one run of each block to warm up
    assert [len(block) for block in blocks["a"].seconds] == [2, 2]


def test_first_image_runs_on_an_empty_cache_first(monkeypatch, tmp_path):
    runs = []

    def run(arguments, environment):
        cache = Path(environment["GLIMT_CACHE_DIR"])
        runs.append((arguments, cache.exists()))
        cache.mkdir(exist_ok=True)
        return len(runs), "0.25"

    monkeypatch.setattr(first_image, "_run", run)
    assert first_image.measure_first_image(tmp_path / "room.toml") == {"cold_s": 1, "warm_s": 4, "import_ms": 250}
    assert [existed for _, existed in runs] == [False] + [True] * 10
    assert runs[0][0][:3] == ["-m", "glimt", "render"]
    assert not Path(runs[0][0][-1]).exists()  # the temporary folder is gone


def test_first_image_tells_why_it_failed(tmp_path):
    with pytest.raises(GlimtError, match=r"first image: .*nowhere\.toml: no such file"):
        first_image.measure_first_image(tmp_path / "nowhere.toml")
    assert first_image._run(["-c", "print(2)"], dict(os.environ))[1] == "2\n"
