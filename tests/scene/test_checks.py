"""What the constructors of scene objects refuse: each message names the object and the field."""

import numpy as np
import pytest

from glimt import (
    Camera,
    DirectionalLight,
    GlimtError,
    Instance,
    Material,
    Mesh,
    Orbit,
    Path,
    PointLight,
    Renderer,
    RenderSettings,
    Scene,
    Sphere,
    SpotLight,
    Texture,
)
from glimt.scene.light import Light

NAN, INF = float("nan"), float("inf")
TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
GREY = np.zeros((2, 2, 3), np.uint8)


def mesh(**changes):
    return Mesh(**{"positions": TRIANGLE[0], "triangles": TRIANGLE[1], "name": "wall", **changes})


def placed(matrix, **changes):
    return Instance(**{"mesh": mesh(), "object_to_world": matrix, "name": "chair", **changes})


def diagonal(*factors):
    return np.column_stack([np.diag(factors), np.zeros(len(factors))])


BAD_NUMBERS = ["red", None, [1, 2], [[1], [1, 2]], NAN, INF, -INF, 1e300, 10**400, object()]
BAD_VECTORS = ["abc", None, 3, (1, 2), (1, 2, 3, 4), [[1], [1, 2]], (NAN, 0, 0), (0, INF, 0), (0, 0, 1e300),
               (10**400, 0, 0), ("a", "b", "c")]
BAD_COLORS = ["red", (1, 2), (NAN, 0, 0), (0, -0.1, 0), -1, INF, 1e300, 10**400, [[1], [1, 2]], {"r": 1}]


@pytest.mark.parametrize("value", BAD_COLORS, ids=repr)
@pytest.mark.parametrize(("field", "make"), [
    ("material 'wood': ambient", lambda v: Material(ambient=v, name="wood")),
    ("material 'wood': diffuse", lambda v: Material(diffuse=v, name="wood")),
    ("material 'wood': specular", lambda v: Material(specular=v, name="wood")),
    ("light 'sun': ambient", lambda v: DirectionalLight(direction=(0, 0, 1), ambient=v, name="sun")),
    ("light 'sun': diffuse", lambda v: DirectionalLight(direction=(0, 0, 1), diffuse=v, name="sun")),
    ("light 'sun': specular", lambda v: DirectionalLight(direction=(0, 0, 1), specular=v, name="sun")),
    ("light 'lamp': attenuation", lambda v: PointLight(position=(0, 0, 0), attenuation=v, name="lamp")),
    ("settings: background", lambda v: RenderSettings(background=v)),
    ("settings: ambient", lambda v: RenderSettings(ambient=v)),
])
def test_colours(field, make, value):
    with pytest.raises(GlimtError, match=f"^{field} "):
        make(value)


@pytest.mark.parametrize("value", BAD_VECTORS, ids=repr)
@pytest.mark.parametrize(("field", "make"), [
    ("camera: position", lambda v: Camera(position=v)),
    ("camera: target", lambda v: Camera(target=v)),
    ("camera: up", lambda v: Camera(up=v)),
    ("sphere 'ball': center", lambda v: Sphere(v, 1, name="ball")),
    ("light 'lamp': position", lambda v: PointLight(position=v, name="lamp")),
    ("light 'spot': direction", lambda v: SpotLight(position=(0, 0, 0), direction=v, name="spot")),
    ("light 'sun': direction", lambda v: DirectionalLight(direction=v, name="sun")),
    ("orbit: center", lambda v: Orbit(center=v)),
    ("orbit: axis", lambda v: Orbit(axis=v)),
    ("path: points", lambda v: Path((0, 1), (v, (0, 0, 0)))),
])
def test_points_and_directions(field, make, value):
    with pytest.raises(GlimtError, match=f"^{field} "):
        make(value)


@pytest.mark.parametrize("value", BAD_NUMBERS, ids=repr)
@pytest.mark.parametrize(("field", "make"), [
    ("camera: fov_deg", lambda v: Camera(fov_deg=v)),
    ("sphere 'ball': radius", lambda v: Sphere((0, 0, 0), v, name="ball")),
    ("light 'lamp': radius", lambda v: PointLight(position=(0, 0, 0), radius=v, name="lamp")),
    ("light 'spot': outer_angle_deg", lambda v: SpotLight(position=(0, 0, 0), direction=(0, 0, 1), outer_angle_deg=v,
                                                          name="spot")),
    ("light 'spot': inner_angle_deg", lambda v: SpotLight(position=(0, 0, 0), direction=(0, 0, 1), inner_angle_deg=v,
                                                          name="spot")),
    ("material 'wood': exponent", lambda v: Material(exponent=v, name="wood")),
    ("material 'wood': reflectivity", lambda v: Material(reflectivity=v, name="wood")),
    ("material 'wood': normal_scale", lambda v: Material(normal_scale=v, name="wood")),
    ("settings: width", lambda v: RenderSettings(width=v)),
    ("settings: height", lambda v: RenderSettings(height=v)),
    ("settings: samples", lambda v: RenderSettings(samples=v)),
    ("settings: max_bounces", lambda v: RenderSettings(max_bounces=v)),
    ("settings: exposure", lambda v: RenderSettings(exposure=v)),
    ("orbit: period", lambda v: Orbit(period=v)),
    ("render: time", lambda v: Renderer(Scene(), threads=1).render(time=v)),
])
def test_numbers(field, make, value):
    with pytest.raises(GlimtError, match=f"^{field} "):
        make(value)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: Camera(fov_deg=180), "camera: fov_deg is 180"),
    (lambda: Camera(fov_deg=0), "camera: fov_deg is 0"),
    (lambda: Camera((1, 2, 3), (1, 2, 3)), r"camera: position and target are the same point \(1.0, 2.0, 3.0\)"),
    (lambda: Camera((0, 5, 0), (0, 0, 0)), "camera: up .* lies along the line of sight"),
    (lambda: Camera((0, 0, 5), (0, 0, 0), (0, 0, -3)), "camera: up .* lies along the line of sight"),
    (lambda: Camera(up=(0, 0, 0)), "camera: up is a zero vector"),
    (lambda: Sphere((0, 0, 0), 0), "sphere 'sphere': radius is 0"),
    (lambda: Sphere((0, 0, 0), -1), "sphere 'sphere': radius is -1, expected 0 to 1e"),
    (lambda: DirectionalLight(direction=(0, 0, 0), name="sun"), "light 'sun': direction is a zero vector"),
    (lambda: SpotLight(position=(0, 0, 0), direction=(0, -0.0, 0)), "light 'light': direction is a zero vector"),
    (lambda: PointLight(position=(0, 0, 0), radius=0), "light 'light': radius is 0"),
    (lambda: PointLight(position=(0, 0, 0), attenuation=(0, 0, 0)), "light 'light': attenuation is 0 0 0"),
    (lambda: SpotLight(position=(0, 0, 0), direction=(0, 0, 1), inner_angle_deg=31), "inner_angle_deg is 31"),
    (lambda: SpotLight(position=(0, 0, 0), direction=(0, 0, 1), outer_angle_deg=181), "outer_angle_deg is 181"),
    (lambda: Material(exponent=-1), "material 'material': exponent is -1"),
    (lambda: Material(exponent=1e7), "material 'material': exponent is 1e"),
    (lambda: Material(reflectivity=1.01), "material 'material': reflectivity is 1.01, expected 0 to 1"),
    (lambda: Material(normal_texture=Texture(GREY)), "normal_texture must have encoding 'linear'"),
    (lambda: Material(diffuse_texture="a.png"), "diffuse_texture is of type str, expected Texture"),
    (lambda: Material(normal_texture=GREY), "normal_texture is of type ndarray, expected Texture"),
    (lambda: Sphere((0, 0, 0), 1, "wood"), "sphere 'sphere': material is of type str, expected Material"),
    (lambda: PointLight(position=(0, 0, 0), motion="up"), "motion is of type str, expected Orbit or Path"),
    (lambda: RenderSettings(width=0), "settings: width is 0, expected 1 to 32768"),
    (lambda: RenderSettings(width=32769), "settings: width is 32769"),
    (lambda: RenderSettings(width=32768, height=32768), "settings: 32768×32768 is more than 100 million pixels"),
    (lambda: RenderSettings(height=2.5), "settings: height is 2.5, expected a whole number"),
    (lambda: RenderSettings(samples=65), "settings: samples is 65"),
    (lambda: RenderSettings(max_bounces=-1), "settings: max_bounces is -1"),
    (lambda: RenderSettings(tone_curve="loud"), "settings: tone_curve is 'loud', expected 'clamp' or 'filmic'"),
    (lambda: Orbit(period=0), "orbit: period is 0 seconds"),
    (lambda: Orbit(period=1e-300), "orbit: period is 0 seconds"),
    (lambda: Orbit(axis=(0, 0, 0)), "orbit: axis is a zero vector"),
    (lambda: Path((0,), ((0, 0, 0),)), "path: times must be two or more"),
    (lambda: Path((0, 0), ((0, 0, 0), (1, 1, 1))), "path: times must be two or more, each later"),
    (lambda: Path((1, 0), ((0, 0, 0), (1, 1, 1))), "path: times must be two or more, each later"),
    (lambda: Path((0, NAN), ((0, 0, 0), (1, 1, 1))), "path: times has values that are not finite"),
    (lambda: Path((0, 1), ((0, 0, 0),)), r"path: points has shape \(1, 3\), expected \(2, 3\)"),
    (lambda: Scene().add("ball"), "scene: cannot add a str; expected a mesh, instance, sphere or light"),
    (lambda: Renderer(Scene([mesh()])), "scene: one of objects is of type Mesh, expected Instance or Sphere"),
    (lambda: Renderer(Scene([], [Light()])), "scene: one of lights is of type Light, expected PointLight or Direct"),
])
def test_what_makes_no_sense(make, message):
    with pytest.raises(GlimtError, match=message):
        make()


@pytest.mark.parametrize(("changes", "message"), [
    ({"positions": [[0, 0]]}, r"positions has shape \(1, 2\), expected \(n, 3\)"),
    ({"positions": "corner"}, "positions is not an array of numbers"),
    ({"positions": [[0, 0, 0], [1, 0]]}, "positions is not an array of numbers"),
    ({"positions": [[0, 0, NAN]]}, "positions has values that are not finite"),
    ({"positions": [[0, 0, 1e300]] * 3}, "positions has a coordinate beyond 1e[+]15; scale the scene down"),
    ({"triangles": [[0, 1]]}, r"triangles has shape \(1, 2\), expected \(n, 3\)"),
    ({"triangles": [[0, 1, 3]]}, r"triangle 0 refers to vertices \[0, 1, 3\] of 3"),
    ({"triangles": [[0, 1, 2], [-1, 1, 2]]}, "triangle 1 refers to vertices"),
    ({"triangles": [[0, 1, NAN]]}, "triangles has values that are not whole numbers"),
    ({"triangles": [[0, 1, 1.5]]}, "triangles has values that are not whole numbers"),
    ({"triangles": [[0, 1, 1e300]]}, "triangles has values that are not whole numbers"),
    ({"triangles": [[0, 1, 2**70]]}, "triangles is not an array of numbers"),
    ({"triangles": [[0, 1, 2**33]]}, "triangle 0 refers to vertices"),
    ({"normals": [[0, 0, 1]]}, r"normals has shape \(1, 3\), expected \(3, 3\)"),
    ({"normals": [[0, 0, INF]] * 3}, "normals has values that are not finite"),
    ({"texcoords": [[0, 0, 1]] * 3}, r"texcoords has shape \(3, 3\), expected \(3, 2\)"),
    ({"texcoords": [[0, -1e300]] * 3}, "texcoords has a coordinate beyond"),
    ({"materials": []}, "no materials; leave the argument out for plain grey"),
    ({"materials": ["wood"]}, "materials is of type str, expected Material"),
    ({"materials": Material()}, "materials is of type Material, expected list or tuple"),
    ({"material_ids": [1]}, "material_ids go from 1 to 1, there are 1 materials"),
    ({"material_ids": [-1]}, "material_ids go from -1 to -1"),
    ({"material_ids": [0, 0]}, r"material_ids has shape \(2,\), expected \(1\)|material_ids has shape"),
    ({"material_ids": [2**32]}, "material_ids has values that are not whole numbers of 32 bits"),
])
def test_meshes(changes, message):
    with pytest.raises(GlimtError, match=f"^mesh 'wall': ({message})"):
        mesh(**changes)


@pytest.mark.parametrize(("matrix", "message"), [
    (np.zeros((3, 4)), "is singular"), (diagonal(1, 1, 0), "is singular"), (diagonal(1, 1, 1e-9), "is singular"),
    (np.column_stack([np.ones((3, 3)), np.zeros(3)]), "is singular"), (diagonal(1e-30, 1e-30, 1e-30), "is singular"),
    (np.eye(3), r"has shape \(3, 3\), expected \(n, 4\)"), (np.eye(5, 4), r"has shape \(5, 4\), expected \(3, 4\)"),
    (np.ones((4, 4)), "the last row"), (diagonal(NAN, 1, 1), "not finite"), (diagonal(1, INF, 1), "not finite"),
    (diagonal(1e300, 1, 1), "has an entry beyond"), ("turn", "not an array of numbers"), (None, "has shape"),
    ([[1, 0, 0, 0], [1]], "not an array of numbers"), (np.vstack([diagonal(1, 1, 1), [0, 0, 0, NAN]]), "not finite"),
])
def test_matrices(matrix, message):
    with pytest.raises(GlimtError, match=f"^instance 'chair': .*{message}"):
        placed(matrix)


@pytest.mark.parametrize(("changes", "message"), [
    ({"mesh": "chair.obj"}, "mesh is of type str, expected Mesh"),
    ({"material": "wood"}, "material is of type str, expected Material"),
])
def test_instances(changes, message):
    with pytest.raises(GlimtError, match=f"^instance 'chair': {message}"):
        placed(np.eye(3, 4), **changes)


@pytest.mark.parametrize(("changes", "message"), [
    ({"pixels": "wood.png"}, "pixels is not an array of numbers"),
    ({"pixels": np.zeros((2, 2), np.uint8)}, r"pixels has shape \(2, 2\), expected \(n, n, 3\)"),
    ({"pixels": np.zeros((2, 2, 4), np.uint8)}, "pixels has shape"),
    ({"pixels": np.zeros((0, 2, 3), np.uint8)}, "the image has no pixels"),
    ({"pixels": np.zeros((2, 2, 3), np.uint16)}, "pixels are uint16, expected uint8 0..255 or floats 0..1"),
    ({"pixels": np.full((2, 2, 3), NAN)}, "pixels has values that are not finite"),
    ({"pixels": np.full((2, 2, 3), 1e300)}, "pixels has values that are not finite"),
    ({"pixels": [[[1], [1, 2]]]}, "pixels is not an array of numbers"),
    ({"encoding": "gamma"}, "encoding is 'gamma', expected 'srgb' or 'linear'"),
    ({"wrap": "mirror"}, "wrap is 'mirror', expected 'repeat' or 'clamp'"),
    ({"scale": (1, 2, 3)}, r"scale has shape \(3,\)"), ({"scale": 2}, r"scale has shape \(1,\)"),
    ({"scale": (NAN, 1)}, "scale has values that are not finite"), ({"offset": (1, 1e300)}, "offset has a component"),
    ({"offset": "left"}, "offset is not an array of numbers"),
])
def test_textures(changes, message):
    with pytest.raises(GlimtError, match=f"^texture 'bark': {message}"):
        Texture(**{"pixels": GREY, "name": "bark", **changes})
