"""Normal maps of one known normal: Lambert with that normal, whatever the instance's matrix."""

import numpy as np
import pytest
from pictures import direction, facing, film, normal_texture, picture, pixel, placed, plane, terminator, unit

from glimt import Camera, DirectionalLight, Material, PointLight, Texture, linalg

KD = np.array([0.9, 0.5, 0.2])
TURNED = linalg.rotation((1, 2, 3), 50)[:, :3]
STRETCHED = np.diag([3.0, 0.5, 2.0])
MIRRORED = np.diag([-1.0, 1.0, 1.0])
LIGHTS = [direction(20, 10), direction(40, 100), direction(50, 215), direction(60, 300)]


def _lambert(ng, ns, wi):
    """Return the expected diffuse reflectance."""
    return KD * max(0.0, ns @ wi) * terminator(ng, ns, wi)


def _mapped(normal, **options):
    texture, kept = normal_texture(normal)
    return Material(diffuse=KD, normal_texture=texture, **options), kept


def _seen(thing, material_side, wi):
    """Return the radiance of a thing at the origin, seen from `material_side`, under light from wi."""
    up = (0, 1, 0) if abs(material_side[1]) < 0.9 else (1, 0, 0)
    return pixel(thing, DirectionalLight(direction=-wi), camera=Camera(5 * material_side, (0, 0, 0), up, 10.0))


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("around", [0, 90, 180, 225])
@pytest.mark.parametrize("tilt", [0, 10, 30, 55])
def test_tilted_normal_on_a_plane(tilt, around, smooth):
    material, ns = _mapped(direction(tilt, around))
    for wi in LIGHTS:
        seen = pixel(plane(material, smooth=smooth), DirectionalLight(direction=-wi), camera=facing())
        np.testing.assert_allclose(seen, _lambert(np.array([0, 0, 1.0]), ns, wi), rtol=2e-5, atol=1e-6)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("tilted", [(0.5, 0, 1), (0, 0.5, 1), (-0.3, -0.6, 1)])
@pytest.mark.parametrize("matrix", [TURNED, STRETCHED, MIRRORED, -np.eye(3), TURNED @ STRETCHED, TURNED @ MIRRORED,
                                    STRETCHED @ TURNED, MIRRORED @ TURNED @ STRETCHED])
def test_tilted_normal_on_a_placed_plane(tilted, matrix, smooth):
    """The frame goes along with the surface: tangents by the matrix, the normal by its transposed inverse."""
    material, kept = _mapped(tilted)
    tangent, bitangent = unit(matrix[:, 0]), unit(matrix[:, 1])
    normal = unit(np.linalg.inv(matrix).T[:, 2])
    ns = unit(np.column_stack([tangent, bitangent, normal]) @ kept)
    thing = placed(plane(material, smooth=smooth), matrix)
    frame = np.column_stack([tangent, np.cross(normal, tangent), normal])
    for wi in (frame @ light for light in LIGHTS):
        np.testing.assert_allclose(_seen(thing, normal, wi), _lambert(normal, ns, wi), rtol=2e-5, atol=1e-6)
        if not np.allclose(tilted[:2], 0):
            assert not np.allclose(_seen(thing, normal, wi), _lambert(normal, normal, wi), rtol=1e-3)


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("matrix", [np.eye(3), MIRRORED, TURNED @ STRETCHED])
def test_from_behind_the_same_surface_is_seen(matrix, smooth):
    """A bump becomes a dent: the normal is turned round as a whole."""
    material, kept = _mapped((0.4, -0.3, 1))
    normal = unit(np.linalg.inv(matrix).T[:, 2])
    ns = unit(np.column_stack([unit(matrix[:, 0]), unit(matrix[:, 1]), normal]) @ kept)
    thing = placed(plane(material, smooth=smooth), matrix)
    frame = np.column_stack([unit(matrix[:, 0]), np.cross(normal, unit(matrix[:, 0])), normal])
    for wi in (frame @ -light for light in LIGHTS):
        np.testing.assert_allclose(_seen(thing, -normal, wi), _lambert(-normal, -ns, wi), rtol=2e-5, atol=1e-6)


@pytest.mark.parametrize("smooth", [False, True])
def test_texcoords_of_the_other_handedness(smooth):
    """u grows to the left: +X of the map does so too, +Y stays up."""
    material, kept = _mapped((0.4, 0.25, 1))
    square = plane(material, smooth=smooth, flip_u=True)
    for wi in LIGHTS:
        np.testing.assert_allclose(_seen(square, np.array([0, 0, 1.0]), wi),
                                   _lambert(np.array([0, 0, 1.0]), kept * [-1, 1, 1], wi), rtol=2e-5)


def test_green_tilts_the_normal_to_the_top_of_the_texture():
    up, _ = _mapped((0, 0.6, 1))
    above, below = (DirectionalLight(direction=(0, y, -1)) for y in (-1, 1))
    assert pixel(plane(up), above, camera=facing())[0] > 2 * pixel(plane(up), below, camera=facing())[0]


@pytest.mark.parametrize("tilt", [20, 45, 60])
def test_terminator_softens_what_the_surface_hardly_sees(tilt):
    """Light at 60° to 89.9° on the side to which the normal leans: the mapped normal sees all of it."""
    material, ns = _mapped(direction(tilt))
    ng = np.array([0, 0, 1.0])
    below_one = 0
    for angle in (60, 75, 85, 88, 89.9):
        wi = direction(angle)
        factor = terminator(ng, ns, wi)
        below_one += factor < 0.9
        np.testing.assert_allclose(pixel(plane(material), DirectionalLight(direction=-wi), camera=facing()),
                                   KD * (ns @ wi) * factor, rtol=5e-5)
    assert below_one >= 2
    assert not pixel(plane(material), DirectionalLight(direction=-direction(90.1)), camera=facing()).any()


def test_terminator_softens_highlights_too():
    texture, ns = normal_texture(direction(40))
    square = plane(Material(diffuse=0, specular=KD, exponent=3, normal_texture=texture))
    wi = direction(80)
    halfway = unit(wi + [0, 0, 1])
    factor = terminator((0, 0, 1), ns, wi)
    assert factor < 0.6
    np.testing.assert_allclose(pixel(square, DirectionalLight(direction=-wi), camera=facing()),
                               KD * (ns @ halfway)**3 * factor, rtol=5e-5)


@pytest.mark.parametrize("scale", [0, 0.5, 1, 2, -1])
def test_normal_scale_multiplies_the_tilt(scale):
    material, kept = _mapped((0.3, 0.4, 1), normal_scale=scale)
    ns = unit(kept * [scale, scale, 1])
    for wi in LIGHTS:
        np.testing.assert_allclose(pixel(plane(material), DirectionalLight(direction=-wi), camera=facing()),
                                   _lambert(np.array([0, 0, 1.0]), ns, wi), rtol=3e-4 if scale == 0 else 3e-5)


def test_normals_of_any_length_are_read():
    """JPEG leaves normals as short as 0.3."""
    _, ns = normal_texture((0.3, 0.4, 1))
    short = Texture(np.tile(np.float32(0.3 * ns / 2 + 0.5), (4, 4, 1)), "linear")
    material = Material(diffuse=KD, normal_texture=short)
    for wi in LIGHTS:
        np.testing.assert_allclose(pixel(plane(material), DirectionalLight(direction=-wi), camera=facing()),
                                   _lambert(np.array([0, 0, 1.0]), ns, wi), rtol=1e-2)
    grey = Material(diffuse=KD, normal_texture=Texture(np.full((2, 2, 3), 0.5, np.float32), "linear"))
    seen = film(plane(grey), DirectionalLight(direction=(0, 0, -1)), camera=facing(), size=(5, 5))
    assert seen.counters.non_finite == 0
    assert (seen.radiance > 0).all()


@pytest.mark.parametrize("view", [30, 60, 80, 88])
def test_normals_that_face_away_are_bent_back(view):
    """No black pixels: where the mapped normal points away from the viewer it is turned until it grazes."""
    material, kept = _mapped(direction(80, 180))  # leans to -X
    wo = direction(view)  # stands on the side of +X
    camera = Camera(4 * wo, (0, 0, 0), (0, 1, 0), 20)
    assert kept @ wo < 0.02
    ns = unit(kept + wo * (0.02 - kept @ wo))
    assert ns @ wo > 0.0199
    lamp = PointLight(position=10 * wo, attenuation=(1, 0, 0))
    seen = film(plane(material, half=0.2), lamp, camera=camera, size=(9, 9))
    assert seen.counters.non_finite == 0
    assert (seen.radiance[4, 4] > 0).all()
    np.testing.assert_allclose(seen.radiance[4, 4], _lambert(np.array([0, 0, 1.0]), ns, wo), rtol=2e-3)


def test_a_rough_map_has_no_black_pixels_towards_the_light():
    rng = np.random.default_rng(3)
    normals = unit(rng.normal(size=(64, 64, 3)) * [1, 1, 0.3] + [0, 0, 0.3])
    normals[..., 2] = np.abs(normals[..., 2])
    material = Material(diffuse=1, normal_texture=Texture((normals / 2 + 0.5).astype(np.float32), "linear"))
    for view in (0, 50, 85):
        camera = Camera(4 * direction(view), (0, 0, 0), (0, 1, 0), 5)
        seen = picture(plane(material, half=9), PointLight(position=4 * direction(view)), camera=camera, size=(64, 64))
        assert (seen > 0).all()
