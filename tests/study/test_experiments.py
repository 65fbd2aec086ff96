"""Settings of the figures: one thing varied at a time, everything else as in the base configuration."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import closed_meshes
import glimt
from glimt.errors import GlimtError
from glimt.renderer import Renderer
from glimt.study import experiments
from glimt.study.experiments import FIGURES, Study, all_mirrors, base_of, chosen_figures
from glimt.study.vertices import finer, first_vertices, in_order, placed_vertices

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def room():
    return base_of(glimt.load(ROOT / "examples" / "stone_room.toml"))


def curves(room, name, engine="cpu", **options):
    kind = next(kind for kind in FIGURES.values() if kind.name == name)
    return kind.settings(Study(room, engine, **options))


def test_the_base_is_the_papers(room):
    settings = room.settings
    assert (settings.width, settings.height, settings.samples, settings.max_bounces) == (400, 400, 1, 0)
    assert placed_vertices(room) == 990
    assert sorted(type(light).__name__ for light in room.lights) == ["DirectionalLight", "PointLight"]


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("engine", ["cpu", "gpu"])
def test_every_figure_has_settings_in_order_with_labels_of_their_own(room, engine, quick):
    for kind in FIGURES.values():
        if engine not in kind.engines:
            continue
        for name, settings in kind.settings(Study(room, engine, quick)).items():
            places = [each.x for each in settings if each.x is not None]
            assert places == sorted(places), name
            assert len({each.label for each in settings}) == len(settings) > 0


def differing(setting, base):
    """Return which render settings a setting has otherwise than the base, and whether objects or lights."""
    fields = {name for name, value in vars(setting.scene.settings).items() if value != getattr(base.settings, name)}
    return (fields | ({"objects"} if setting.scene.objects != base.objects else set())
            | ({"lights"} if setting.scene.lights != base.lights else set())
            | ({"camera"} if setting.scene.camera is not base.camera else set())
            | ({"options"} if setting.options != type(setting.options)() else set())
            | ({"threads"} if setting.threads else set()))


@pytest.mark.parametrize(("name", "varied"), [
    ("groups", {"options"}), ("pixels", {"width", "height"}), ("lights", {"lights"}), ("threads", {"threads"}),
    ("samples", {"samples"})])
def test_one_thing_is_varied_at_a_time(room, name, varied):
    for settings in curves(room, name).values():
        for setting in settings:
            assert differing(setting, room) <= varied


def test_bounces_with_the_scenes_mirrors_and_with_all(room):
    own, every = curves(room, "bounces").values()
    assert [each.scene.settings.max_bounces for each in own] == list(range(11)) == [each.x for each in every]
    assert all(differing(each, room) <= {"max_bounces"} for each in own)
    material = {thing.material.name: thing.material.reflectivity for thing in every[3].scene.spheres()}
    assert material["silver"] == 0.85
    assert material["lacquer"] == 0.5


def test_mirrors_everywhere_send_every_ray_on(room):
    mirrored = all_mirrors(room)
    mirrored.settings = replace(room.settings, width=64, height=64, max_bounces=2)
    counters = Renderer(mirrored, engine="cpu").render().counters
    assert counters.mirror > 1.9 * 64 * 64  # but for those that leave by the skylight
    assert room.spheres()[3].material.reflectivity < 0.1  # the scene itself is as it was


def test_lights_keep_those_that_are_no_points(room):
    for setting in curves(room, "lights")["point lights"]:
        assert [type(light).__name__ for light in setting.scene.lights] == [
            "DirectionalLight", *["PointLight"] * int(setting.x)]


def test_vertices_are_added_with_the_outer_box_last(room):
    added, grown = curves(room, "vertices").values()
    assert [placed_vertices(each.scene) for each in added] == [each.x for each in added]
    assert added[-1].x == 990
    assert in_order(room)[-1].name == "room"
    inside = [each for each in added if each.x <= 900]
    assert len(inside) >= 10
    assert not any(thing.name == "room" for each in inside for thing in each.scene.instances())
    assert len(added) - len(inside) >= 3
    assert [each.x for each in grown] == [990 * 4**k for k in range(7)]
    assert grown[-1].x / 3 > 1e6
    assert all(len(each.scene.spheres()) == 4 for each in [*added, *grown])


def test_brute_force_stands_beside_the_trees(room):
    found = curves(room, "vertices", brute_force=True)
    assert len(found) == 4
    trees, forced = found["objects added, the outermost last"], found["objects added, brute force"]
    assert [each.x for each in forced] == [each.x for each in trees]
    assert all(each.options.brute_force for each in forced)
    assert not any(each.options.brute_force for each in trees)
    assert max(each.x for each in found["cut finer, brute force"]) <= 75_000


def test_the_first_vertices_are_whole_triangles_of_the_first_objects(room):
    some = first_vertices(room, 3 * 50 + 2)
    assert [len(thing.mesh.triangles) for thing in some.instances()] == [12, 12, 12, 12, 2]
    np.testing.assert_array_equal(some.instances()[4].mesh.triangles, in_order(room)[4].mesh.triangles[:2])
    assert placed_vertices(first_vertices(room, 10**9)) == 990


def test_cut_surfaces_look_the_same(room):
    small = replace(room, settings=replace(room.settings, width=96, height=96))
    usual, cut = (Renderer(each, engine="cpu").render().image() for each in (small, finer(finer(small))))
    differing = (np.abs(usual.astype(int) - cut).max(-1) > 8).mean()
    assert differing < 0.02  # normals in the middle of an edge, and what falls on edges
    assert placed_vertices(finer(finer(small))) == 16 * 990


def test_instances_of_one_mesh_stay_one_mesh_when_cut():
    ball = closed_meshes.icosphere(1)
    scene = glimt.Scene(objects=[glimt.Instance(ball), glimt.Instance(ball), glimt.Sphere((0, 0, 0), 1.0)])
    cut = finer(scene)
    assert cut.objects[0].mesh is cut.objects[1].mesh
    assert len(cut.objects[0].mesh.triangles) == 4 * len(ball.triangles)
    assert isinstance(cut.objects[2], glimt.Sphere)


def test_scenes_without_meshes_or_lights_have_the_other_figures():
    bare = base_of(glimt.Scene(objects=[glimt.Sphere((0, 0, 0), 1.0)]))
    for name in ("vertices", "instances"):
        with pytest.raises(GlimtError, match="no meshes"):
            curves(bare, name)
    assert len(curves(bare, "lights")["point lights"]) == 11


def test_a_scene_of_one_mesh(tmp_path):
    one = base_of(glimt.Scene(objects=[glimt.Instance(closed_meshes.icosphere(1))]))
    added = curves(one, "vertices")["objects added, the outermost last"]
    assert [each.x for each in added][-1] == placed_vertices(one)
    assert len(added) >= 3
    assert curves(one, "instances")


def test_a_scene_that_is_fine_enough_is_not_cut(room, monkeypatch):
    monkeypatch.setattr(experiments, "_MOST_TRIANGLES", 100)
    assert [each.x for each in curves(room, "vertices")["the same surfaces cut finer"]] == [990]


@pytest.mark.parametrize(("text", "numbers"), [("3", [3]), ("10, 2,2", [2, 10]), (None, list(FIGURES))])
def test_figures_by_number(text, numbers):
    assert chosen_figures(text) == numbers


@pytest.mark.parametrize("text", ["1", "11", "x", "", "3,,4", "-3", "²"])
def test_figures_that_are_none(text):
    with pytest.raises(GlimtError, match="expected some of 2, 3, 4"):
        chosen_figures(text)
