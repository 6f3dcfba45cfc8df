"""Images without a display: where the sun's shadows fall and which colors come out."""
import numpy as np
import pybullet
import pytest

from img_recog.simulation import rendering
from img_recog.simulation.rendering import FLOOR_SHADOW, GREY, SUN, Camera, render

RED = (0.8, 0.1, 0.2)
ABOVE = Camera((0.0, 0.0, 0.0), 3.0, 0.0, -89.99)
SIZE = (320, 240)
HALF_VIEW = np.tan(np.radians(rendering.FIELD_OF_VIEW / 2))
SUN_COSINES = np.array(SUN) / np.linalg.norm(SUN)


@pytest.fixture
def client():
    """Return a client without bodies."""
    number = pybullet.connect(pybullet.DIRECT)
    yield number
    pybullet.disconnect(physicsClientId=number)


def add_box(client, center, half, color=RED):
    """Add a visible box with half sides `half`."""
    shape = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=half,
                                       rgbaColor=(*color, 1), physicsClientId=client)
    pybullet.createMultiBody(0, -1, shape, center, physicsClientId=client)


def seen(image, camera, point):
    """Return row and column in which `point` appears."""
    height, width, _ = image.shape
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        camera.target, camera.distance, camera.yaw, camera.pitch, 0, 2)
    projection = pybullet.computeProjectionMatrixFOV(rendering.FIELD_OF_VIEW, width / height,
                                                     0.1, 100)
    x, y, _, w = np.array((*point, 1)) @ np.reshape(view, (4, 4)) @ np.reshape(projection, (4, 4))
    return int(round(height * (1 - y / w) / 2)) - 1, int(round(width * (1 + x / w) / 2))


def color_at(image, camera, point):
    """Return the color with which `point` appears."""
    return image[seen(image, camera, point)].tolist()


def assert_shade(image, camera, point, shade):
    """Check that a red point appears with this share of its color."""
    wanted = [255 * shade * channel for channel in RED]
    assert color_at(image, camera, point) == pytest.approx(wanted, abs=3)


def shadow_end(image, camera, start):
    """Return how far from `start`, in m, the shadow reaches on the floor away from the sun."""
    away = -np.array(SUN[:2]) / np.hypot(*SUN[:2])
    for far in np.arange(0, 2, 0.002):
        point = (*(start + far * away), 0)
        if color_at(image, camera, point) == [GREY] * 3:
            return far
    return None


def test_image_has_the_wanted_shape(client):
    image = render(client, ABOVE, 200, 120)
    assert image.shape == (120, 200, 3)
    assert image.dtype == np.uint8


@pytest.mark.parametrize('pitch', [-89.99, -42, 0, 30])
def test_empty_world_is_grey_throughout(client, pitch):
    image = render(client, ABOVE._replace(pitch=pitch), *SIZE)
    assert np.unique(image).tolist() == [GREY]


@pytest.mark.parametrize('yaw', [0, 90, 180, -90])
def test_top_of_a_box_is_lit_evenly(client, yaw):
    add_box(client, (0, 0, 0.25), (0.25, 0.25, 0.25))
    camera = ABOVE._replace(yaw=yaw)
    image = render(client, camera, *SIZE)
    assert_shade(image, camera, (0, 0, 0.5), 0.75 + 0.25 * SUN_COSINES[2])
    # nothing else of the box is seen, and the top has no outline
    body = image[image[:, :, 0] > image[:, :, 1] + 50.0]
    assert len(body) == pytest.approx((0.5 / 2.5 * SIZE[1] / 2 / HALF_VIEW) ** 2, rel=0.1)
    assert len(np.unique(body, axis=0)) == 1


def test_shadow_lies_on_the_side_away_from_the_sun(client):
    add_box(client, (0, 0, 0.25), (0.25, 0.25, 0.25))
    image = render(client, ABOVE, *SIZE)
    assert color_at(image, ABOVE, (-0.4, 0.03, 0)) == [FLOOR_SHADOW] * 3
    assert color_at(image, ABOVE, (0.4, 0.03, 0)) == [GREY] * 3
    assert color_at(image, ABOVE, (-0.4, -0.4, 0)) == [GREY] * 3
    assert color_at(image, ABOVE, (-0.4, 0.4, 0)) == [GREY] * 3


@pytest.mark.parametrize('height', [0.5, 1.0])
def test_shadow_is_as_long_as_the_sun_is_low(client, height):
    thin = 0.05
    add_box(client, (0.2, 0, height / 2), (thin, 0.4, height / 2))
    camera = ABOVE._replace(distance=5.0)
    image = render(client, camera, 640, 480)
    start = np.array((-0.05, 0.1))
    wanted = (0.2 - thin - height * SUN[0] / SUN[2] - start[0]) * np.hypot(*SUN[:2]) / -SUN[0]
    assert shadow_end(image, camera, start) == pytest.approx(wanted, abs=0.03)


def test_shadow_of_a_small_body_is_exact_near_the_target(client):
    half = 0.07
    add_box(client, (0, 0, half), (half, half, half))
    camera = Camera((0, 0, 0.1), 1.7, -90, -42)
    image = render(client, camera, 640, 480)
    # the shadow of the top's edge, 7 cm from the middle
    wanted = (half + 2 * half * SUN[0] / SUN[2]) * np.hypot(*SUN[:2]) / SUN[0] - half
    start = -half * np.array(SUN[:2]) / np.hypot(*SUN[:2]) - (0.01, 0)
    assert shadow_end(image, camera, start) == pytest.approx(wanted - 0.01, abs=0.01)


@pytest.mark.parametrize('side', [0.0, 0.006, 0.012, 0.018])
def test_a_rod_of_a_centimetre_casts_a_shadow_near_the_target(client, side):
    add_box(client, (0, side, 0.1), (0.005, 0.005, 0.1))
    camera = Camera((0, 0, 0.1), 1.0, -90, -42)
    image = render(client, camera, 640, 480)
    for height in np.linspace(0.02, 0.18, 17):
        x, y, _ = np.array((0, side, 0)) - np.array(SUN) * height / SUN[2]
        assert color_at(image, camera, (x, y, 0)) == [FLOOR_SHADOW] * 3
        for aside in (-0.015, 0.015):
            assert color_at(image, camera, (x, y + aside, 0)) == [GREY] * 3


def test_small_body_far_from_the_origin_casts_its_shadow(client):
    add_box(client, (-12, 15, 0.25), (0.25, 0.25, 0.25))
    camera = ABOVE._replace(target=(-12, 15, 0))
    image = render(client, camera, *SIZE)
    assert color_at(image, camera, (-12.4, 15.03, 0)) == [FLOOR_SHADOW] * 3
    assert color_at(image, camera, (-11.6, 15.03, 0)) == [GREY] * 3


@pytest.mark.parametrize('yaw, normal', [
    (0, (0, -1)), (90, (1, 0)), (180, (0, 1)), (-90, (-1, 0))])
def test_sides_are_as_bright_as_in_the_window(client, yaw, normal):
    add_box(client, (0, 0, 0.5), (0.5, 0.5, 0.5))
    camera = Camera((0, 0, 0.5), 3, yaw, 0)
    cosine = SUN_COSINES[:2] @ normal
    shade = 0.75 + 0.25 * cosine if cosine > 0 else 0.675 + 0.175 * cosine
    image = render(client, camera, *SIZE)
    for along, up in ((0, 0.5), (-0.45, 0.9), (0.45, 0.1)):
        x, y = 0.5 * normal[0] - along * normal[1], 0.5 * normal[1] + along * normal[0]
        assert_shade(image, camera, (x, y, up), shade)


def test_bodies_shadow_one_another(client):
    add_box(client, (0, 0, 0.1), (1.0, 1.0, 0.1))
    add_box(client, (0.3, 0, 0.6), (0.1, 0.1, 0.4))
    image = render(client, ABOVE, *SIZE)
    lit = 0.75 + 0.25 * SUN_COSINES[2]
    assert_shade(image, ABOVE, (0.0, 0.05, 0.2), 0.87 * lit)
    assert_shade(image, ABOVE, (0.8, 0.0, 0.2), lit)


@pytest.mark.parametrize('distance, visible', [(0.03, False), (0.1, True)])
def test_a_body_nearer_than_5_cm_is_not_seen(client, distance, visible):
    add_box(client, (0, -3 + distance, 0.5), (0.3, 0.005, 0.3))
    image = render(client, Camera((0, 0, 0.5), 3, 0, 0), *SIZE)
    assert (image[10, SIZE[0] // 2].tolist() != [GREY] * 3) is visible


def test_floor_hides_what_is_below_it(client):
    add_box(client, (0, 0, -0.3), (0.5, 0.5, 0.25))
    assert np.unique(render(client, ABOVE, *SIZE)).tolist() == [GREY]


def test_shadows_end_at_the_horizon(client):
    # above what the camera sees; its shadow lies about the origin
    add_box(client, 4 * np.array(SUN), (0.5, 0.5, 0.05))
    camera = Camera((0, 0, 1), 3, 0, 0)
    image = render(client, camera, *SIZE)
    assert color_at(image, camera, (0, 0, 0)) == [FLOOR_SHADOW] * 3
    assert np.unique(image[:SIZE[1] // 2]).tolist() == [GREY]


def test_light_of_the_window_comes_from_gazebos_sun(client):
    assert SUN == (0.5, -0.1, 0.9)
    pybullet.configureDebugVisualizer(physicsClientId=client, **rendering.WINDOW_LIGHT)
    position = np.array(rendering.WINDOW_LIGHT['lightPosition'])
    assert position / np.linalg.norm(position) == pytest.approx(SUN_COSINES)


@pytest.mark.parametrize('camera', [
    Camera((0.1, 0.2, 0.1), 1.5, 30, -40), Camera((0.5, 0.0, 0.0), 3.99, -60, -20),
    Camera((0.0, 0.0, 0.0), 4.0, -90, -70), Camera((0.0, 0.0, 0.5), 2.5, 200, 5)])
def test_every_part_of_a_scene_is_as_bright_as_it_was(client, camera):
    add_box(client, (0, 0, 0.1), (0.3, 0.2, 0.1))
    add_box(client, (0.2, 0.1, 0.4), (0.05, 0.05, 0.2), (0.2, 0.6, 0.4))
    add_box(client, (-1.2, 0.7, 0.5), (0.1, 0.6, 0.5), (0.9, 0.9, 0.9))
    pybullet.createMultiBody(0, -1, pybullet.createVisualShape(
        pybullet.GEOM_SPHERE, radius=0.15, rgbaColor=(0.3, 0.3, 0.9, 1), physicsClientId=client),
        (0.5, -0.5, 0.15), physicsClientId=client)
    image = render(client, camera, 160, 120)
    means = image.reshape(6, 20, 8, 20, 3).mean(axis=(1, 3, 4))
    # a pixel at an edge may differ
    assert means == pytest.approx(np.array(BRIGHTNESS[camera.distance]), abs=0.3)


# of parts of 20 x 20 px, by the distance of the camera
BRIGHTNESS = {
    1.5: (
        (199, 199, 191.8, 178, 175.2, 178, 178, 178),
        (195.8, 185.4, 178, 162.1, 116.6, 178, 178, 178),
        (178, 160.2, 109.1, 114.4, 116.7, 178, 178, 178),
        (178, 112, 84.2, 89.6, 102.5, 178, 178, 178),
        (178, 177.5, 140.9, 92.9, 154, 178, 178, 178),
        (178, 178, 178, 161.9, 163.3, 178, 178, 178)),
    3.99: (
        (178, 178, 178, 178, 178, 178, 178, 178),
        (168, 179.1, 178, 178, 178, 178, 178, 178),
        (134, 173.9, 177.6, 137.9, 161.5, 175.9, 178, 178),
        (134.9, 167.2, 170, 127.1, 167.4, 177.7, 178, 178),
        (157.9, 172.2, 178, 178, 178, 178, 178, 178),
        (178, 178, 178, 178, 178, 178, 178, 178)),
    4.0: (
        (178, 178, 178, 178, 178, 178, 178, 178),
        (178, 178, 178, 178, 175.3, 177.3, 178, 178),
        (178, 178, 178, 151.3, 144.3, 174.9, 178, 178),
        (178, 178, 178, 159.2, 157.2, 178, 178, 178),
        (181.8, 188.8, 188.8, 186, 178, 178, 178, 178),
        (182.9, 177.2, 171.8, 173.2, 178, 178, 178, 178)),
    2.5: (
        (178, 178, 178, 178, 178, 178, 178, 186.6),
        (178, 178, 178, 178, 178, 178, 178, 190.9),
        (178, 178, 178, 163.5, 178, 178, 178, 190.2),
        (178, 178, 178, 117.6, 156.5, 178, 178, 189.3),
        (178, 178, 178, 127.2, 122.9, 177.3, 178, 186.6),
        (178, 178, 178, 178, 178, 178, 178, 178.1)),
}
