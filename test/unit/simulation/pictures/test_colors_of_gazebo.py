"""Colors as Gazebo 11 draws them, without a graphics card: its figures, within 8 of 255."""
import math

import numpy as np
import pytest

from img_recog import rotations
from img_recog.formats import world_file
from img_recog.rendering.camera import Camera
from img_recog.simulation import assembly
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.drawn import at, loaded, looking_down
from img_recog_helpers.sdf import sdf

TOLERANCE = 8
CAMERA = Camera(160, 120, 1.0)
SUN = '<include><uri>model://sun</uri></include>'
GROUND = '<include><uri>model://ground_plane</uri></include>'
VISUAL = ('<visual name="v"><geometry>{}</geometry><material>{}</material>{}</visual>')
MODEL = '<model name="{}"><static>1</static><pose>{} 0 0 0</pose><link name="l">{}</link></model>'
BOX = '<box><size>0.3 0.3 0.3</size></box>'
PLANE = '<plane><size>20 20</size></plane>'
RED = '<ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse>'
WHITE = '<ambient>1 1 1 1</ambient><diffuse>1 1 1 1</diffuse>'
HALF = '<diffuse>.5 .5 .5 1</diffuse>'
DARK = '<scene><ambient>0 0 0 1</ambient><background>0 0 0 1</background></scene>'


def script(name, more=''):
    return '<script><name>Gazebo/{}</name></script>{}'.format(name, more)


def color(value):
    return '<ambient>{0} 1</ambient><diffuse>{0} 1</diffuse>'.format(value)


def light(kind, height, more='', inside=HALF + '<specular>0 0 0 1</specular>'):
    place = (str(height) + ' 0 0 0').split()[:4]
    return '<light name="l" type="{}"><pose>0 0 {}</pose>{}{}</light>'.format(
        kind, ' '.join(place), inside, more)


def fading(reach, constant, linear, quadratic):
    return ('<attenuation><range>{}</range><constant>{}</constant><linear>{}</linear><quadratic>'
            '{}</quadratic></attenuation>'.format(reach, constant, linear, quadratic))


def cone(inner, outer, falloff):
    return fading(100, 1, 0, 0) + (
        '<spot><inner_angle>{}</inner_angle><outer_angle>{}</outer_angle><falloff>{}</falloff>'
        '</spot>'.format(inner, outer, falloff))


def seen(inside, pose, points):
    """Return the colors of points (n, 3) of a world in the image of a camera."""
    world = world_file.read('a.world', {}, read_file=lambda path: sdf(inside))
    built = assembly.build(PhysicsSettings(), world, [])
    parts = Parts(built)
    image = loaded(parts.scene(), parts.poses()).draw(
        CAMERA, pose, parts.poses())
    fx, fy, cx, cy = CAMERA.intrinsics
    found = []
    for point in points:
        ahead, left, up = (np.array(point) - pose[:3, 3]) @ pose[:3, :3]
        found.append(image[round(cy - fy * up / ahead), round(cx - fx * left / ahead)])
    return np.array(found, int)


def assert_close(found, expected):
    expected = np.array([each if np.ndim(each) else [each] * 3 for each in expected])
    assert np.abs(found - expected).max() <= TOLERANCE, found.tolist()


# of a material: the color of a face turned from the sun, and of the upper one; None: not measured
MATERIALS = {
    color('1 0 0'): ([102, 0, 0], [255, 0, 0]), color('0.5 0.5 0.5'): (51, 140),
    color('0.8 0.4 0.1'): ([82, 41, 10], None), color('0.1 0.1 0.1'): (None, 28), '': (102, 255),
    '<diffuse>1 0 0 1</diffuse>': (102, None), '<ambient>1 0 0 1</ambient>': ([102, 0, 0], None),
    color('0.5 0.5 0.5') + '<emissive>0.3 0 0 1</emissive>': ([128, 51, 51], None),
    '<emissive>0 1 0 1</emissive>': ([102, 255, 102], None),
    '<ambient>0 0 1 1</ambient><diffuse>1 0 0 1</diffuse>': ([0, 0, 102], None),
    '<lighting>0</lighting>' + color('0.5 0.5 0.5'): (255, 255),
    '<ambient>1 0 0 .5</ambient><diffuse>1 0 0 .5</diffuse>': ([140, 89, 89], None),
    script('Grey'): (31, 155), script('Red'): ([102, 0, 0], [255, 5, 5]),
    script('DarkGrey'): (18, 58), script('Gold'): ([41, 25, 2], [199, 157, 40]),
    script('Wood'): ([79, 54, 29], None), script('WoodFloor'): ([25, 11, 1], None),
    script('Bricks'): ([62, 39, 37], None), script('Road'): ([4, 4, 3], None),
    script('Grass'): ([12, 24, 2], [52, 107, 8]),
    script('RedBright'): ([89, 27, 7], [255, 85, 23]),
    script('Orange'): ([102, 52, 5], [255, 142, 13]), script('Yellow'): ([102, 102, 0], None)}


@pytest.mark.parametrize('material', MATERIALS)
def test_materials_in_the_sun_and_turned_from_it(material):
    world = SUN + MODEL.format('m', '0 0 1', VISUAL.format(BOX, material, ''))
    behind, top = MATERIALS[material]
    if behind is not None:
        assert_close(seen(world, at(-3, 0, 1), [(-0.15, 0, 1)]), [behind])
    if top is not None:
        assert_close(seen(world, looking_down(5.0), [(0, 0, 1.15)]), [top])


# of materials in directed light of 0.5 and highlights of 1 from above: where they stood, the color
@pytest.mark.parametrize('material, place, expected', [
    (script('Gold', '<diffuse>0 0 1 1</diffuse>'), (2, 2), [128, 112, 217]),
    (script('Gold', '<emissive>0 0 .3 1</emissive>'), (2, -1), [235, 200, 186]),
    (script('SkyBlue'), (-1, 2), [39, 70, 224]), (script('RedGlow'), (-1, 1), [255, 0, 0]),
    (script('WhiteGlow'), (0, -2), 255), (script('RedTransparent'), (-1, 1), [128, 0, 0]),
    (script('GreyTransparent'), (-1, -1), 58), (script('BlueLaser'), (-2, 1), [0, 0, 96]),
    (script('TurquoiseGlow'), (0, 2), [230, 255, 255]), (script('LightOn'), (1, 1), [0, 255, 0]),
    (script('JointAnchor'), (-2, 2), 255), ('<specular>1 1 1 1</specular>' + color('0 0 0'),
                                            (0, 2), 0)])
def test_materials_in_light_from_above(material, place, expected):
    x, y = 0.45 * place[0], 0.45 * place[1]
    lamp = light('directional', 10, inside=HALF + '<specular>1 1 1 1</specular>')
    world = '<scene><background>0 0 0 1</background></scene>' + lamp + MODEL.format(
        'm', '{} {} 0'.format(x, y), VISUAL.format(BOX, material, ''))
    assert_close(seen(world, looking_down(4.0), [(x, y, 0.15)]), [expected])


# of a light above the middle of a white plane: the colors at POINTS
POINTS = [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (0, 1, 0), (1.5, 0, 0), (0, 2, 0)]
LIGHTS = {
    light('point', 1): (64, 54, 37, 37, 25, 18),
    light('point', 1, fading(100, 0.2, 0.5, 0.3)): (127, 101, 60, 60, 34, 20),
    light('point', 1, fading(1.3, 1, 0, 0)): (127, 114, 0, 0, 0, 0),
    # the constant and the linear one count as 1 at most
    light('point', 1, fading(100, 2, 0, 0)): (127, 114, 90, 90, 71, 57),
    light('point', 1, fading(100, 1, 2, 0)): (64, 54, 37, 37, 25, 18),
    light('point', 1, fading(100, 1, 0, 4)): (25, 19, 10, 10, 5, 3),
    light('point', 1, fading(100, 0, 0, 0)): (255,) * 6,
    light('spot', 2): (0, 0, 0, 0, 0, 0),
    light('spot', 2, cone(0.6, 1.2, 1)): (127, 124, 60, 60, 0, 0),
    light('spot', 2, cone(0.2, 1.6, 2)): (127, 104, 50, 50, 12, 0),
    light('spot', 2, cone(0.2, 1.6, 0.5) + '<direction>0.3 0.1 -1</direction>'): (
        118, 124, 111, 93, 91, 35),
    light('spot', '2 0.3 0.2 0', cone(0.2, 1.6, 1)): (102, 68, 21, 104, 0, 53),
    light('directional', '2 0.8 0 0'): (89,) * 6,
    light('directional', 2, fading(100, 2, 0.5, 1)): (128,) * 6,
    SUN.replace('</uri>', '</uri><pose>0 0 5 0.5 0 0</pose>'): (146,) * 6,
    '': (0,) * 6,
    MODEL.format('m', '1 0 0', '<pose>0 1 0 0 0 0</pose>' + light('point', 1, fading(9, 1, 0, 0))
                 ): (74, 85, 90, 90, 85, 74)}


@pytest.mark.parametrize('lights', LIGHTS)
def test_lights(lights):
    world = DARK + lights + MODEL.format('g', '0 0 0', VISUAL.format(PLANE, WHITE, ''))
    assert_close(seen(world, looking_down(4.0), POINTS), LIGHTS[lights])


def test_a_highlight_needs_an_exponent_in_any_light():
    lamp = light('point', 1, inside=HALF + '<specular>1 1 1 1</specular>')
    plane = VISUAL.format(PLANE, WHITE + '<specular>1 1 1 1</specular>', '')
    assert_close(seen(DARK + lamp + MODEL.format('g', '0 0 0', plane), looking_down(4.0), POINTS),
                 LIGHTS[light('point', 1)])


def test_ten_lights_are_added():
    world = DARK + ''.join(light('point', '0.3 0 0 0', fading(3, 1, 2, 4),
                                 '<diffuse>.3 .3 .3 1</diffuse>').replace(
        'name="l"', 'name="l{}"'.format(number)).replace('<pose>0 0', '<pose>0 {:.1f}'.format(
            0.4 * number - 1.8)) for number in range(10))
    found = seen(world + MODEL.format('g', '0 0 0', VISUAL.format(PLANE, WHITE, '')),
                 looking_down(4.0), [(0, 0.4 * number - 1.8, 0) for number in range(10)])
    assert_close(found, [75, 93, 98, 100, 101, 101, 100, 98, 93, 75])


FOG = '<scene><fog><color>0 0 1 1</color><type>{}</type>{}</fog></scene>'


CLEAR = '<transparency>0.6</transparency>'


@pytest.mark.parametrize('fog, more, near, far, ground', [
    (FOG.format('linear', '<start>1</start><end>10</end>'), '', [60, 0, 105], [26, 0, 190],
     [0, 0, 255]),
    # fog makes what is transparent less so
    (FOG.format('linear', '<start>1</start><end>10</end>'), CLEAR, [39, 0, 158], [22, 0, 200],
     [0, 0, 255]),
    (FOG.format('exp', '<density>.1</density>'), '', [64, 0, 96], [47, 0, 137], [1, 1, 254]),
    (FOG.format('exp2', '<density>.1</density>'), '', [82, 0, 51], [56, 0, 114], [0, 0, 255]),
    (FOG.format('none', ''), '', [102, 0, 0], [102, 0, 0], [155, 155, 155]),
    ('<scene><fog/></scene>', '', [102, 0, 0], [102, 0, 0], [155, 155, 155])])
def test_fog_is_that_of_the_corners(fog, more, near, far, ground):
    posts = ''.join(MODEL.format('m{}'.format(x), '{} {} 0.5'.format(x, y), VISUAL.format(
        '<box><size>.6 .6 1</size></box>', RED, more)) for x, y in ((2, 0), (5, 1.5)))
    found = seen(fog + SUN + GROUND + posts, at(-3, 0, 1), [
        (1.7, 0, 0.5), (4.7, 1.5, 0.5), (0, 1, 0)])
    assert_close(found, [near, far, ground])


def test_background():
    heights = [(1.0, 0.0, math.tan(angle)) for angle in (0.032, 0.134, 0.265)]
    assert_close(seen(SUN, np.eye(4), heights), [178] * 3)
    assert_close(seen('<scene><background>0 0 1 1</background></scene>', np.eye(4), heights),
                 [[0, 0, 255]] * 3)


# heading and height in degrees of a camera and of what it sees; the sun is at 90 and 51.7
@pytest.mark.parametrize('camera, sky', [
    ((0, 10), {(0, 2): (178, 190, 216), (0, 8): (161, 176, 217), (0, 15): (139, 155, 207)}),
    ((90, 10), {(90, 3): (194, 206, 230), (90, 20): (150, 167, 219)}),
    ((90, 50), {(90, 51.7): (255, 255, 255), (90, 40): (116, 132, 191),
                (80, 51.7): (123, 136, 186)}),
    ((270, 20), {(270, 5): (184, 197, 227), (270, 30): (99, 114, 173)}),
    ((300, 45), {(300, 45): (76, 89, 146)}),
    ((270, -10), {(270, 0.2): (198, 207, 224), (270, -5): (200, 205, 202),
                  (270, -9.15): (187, 187, 173), (270, -14): (178, 178, 178)}),
    ((0, 85), {(0, 89): (68, 81, 137)})])
def test_sky(camera, sky):
    pose = np.eye(4)
    yaw, height = np.radians(camera)
    pose[:3, :3] = rotations.from_rpy((0, -height, yaw))
    points = [rotations.from_rpy((0, -math.radians(up), math.radians(left)))[:, 0]
              for left, up in sky]
    assert_close(seen('<scene><sky><time>10</time></sky></scene>', pose, points),
                 list(sky.values()))
