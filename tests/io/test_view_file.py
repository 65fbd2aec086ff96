"""View files: a picture's settings, camera and lights, to the bit."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import glimt
from glimt.errors import GlimtError
from glimt.io.view_file import apply_view, view_text

NUMBER = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-6)
POINT = st.tuples(NUMBER, NUMBER, NUMBER)
COLOR = st.tuples(*[st.floats(0, 100)] * 3)


@given(POINT, st.floats(1, 170), COLOR, COLOR, st.text(max_size=20).filter(str.strip), st.floats(0, 50))
def test_all_comes_back_to_the_bit(tmp_path_factory, position, fov, diffuse, background, name, time):
    orbit = glimt.Orbit((1.0, 2.0, 3.0), (0.0, 1.0, 0.0), 7.0)
    lights = [glimt.PointLight(position=position, diffuse=diffuse, radius=3.25, name=name or "x", motion=orbit),
              glimt.SpotLight(position=(1.0, 2.0, 3.0), direction=(0.1, -1.0, 0.3), inner_angle_deg=12.5),
              glimt.DirectionalLight(direction=(0.3, -1.0, 0.2), specular=diffuse, motion=orbit)]
    settings = glimt.RenderSettings(123, 45, "adaptive", 3, background, 0.1, -0.7, "filmic")
    camera = glimt.Camera(position, (position[0] + 1.0, position[1] + 0.5, position[2] - 2.0), fov_deg=fov)
    scene = glimt.Scene(lights=lights, camera=camera, settings=settings)
    path = tmp_path_factory.mktemp("view") / "view.toml"
    path.write_text(view_text(scene, time, "made by\na test"), encoding="utf-8")
    again = apply_view(glimt.Scene().add(glimt.Sphere((0.0, 0.0, 0.0), 1.0)), path)
    assert vars(again.settings) == vars(settings)
    assert vars(again.camera) == vars(camera)
    assert len(again.objects) == 1
    assert [type(light) for light in again.lights] == [type(light) for light in lights]
    for light, still in zip(lights, again.lights, strict=True):
        assert still.motion is None
        for key, value in vars(light).items():
            if key not in ("motion", "position", "direction"):
                assert getattr(still, key) == value
    assert again.lights[0].position == lights[0].position_at(time)
    assert again.lights[2].direction == lights[2].direction_at(time)
    assert math.isclose(again.lights[0].radius, 3.25)


def test_objects_have_no_place_in_it(tmp_path):
    path = tmp_path / "view.toml"
    path.write_text("[camera]\nfov_deg = 30\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\n")
    with pytest.raises(GlimtError, match=r"view.toml:3: sphere\[0\]: has no place in a view file"):
        apply_view(glimt.Scene(), path)


@pytest.mark.parametrize("name", ["none.toml", "."])
def test_a_file_that_is_not_there(tmp_path, name):
    with pytest.raises(GlimtError, match=r"no such file|not a regular file"):
        apply_view(glimt.Scene(), tmp_path / name)


def test_a_view_without_a_camera_keeps_the_scene_s(tmp_path):
    path = tmp_path / "view.toml"
    path.write_text("[render]\nsamples = 2\n")
    camera = glimt.Camera()
    scene = apply_view(glimt.Scene(camera=camera), path)
    assert (scene.camera, scene.settings.samples, scene.lights) == (camera, 2, [])
