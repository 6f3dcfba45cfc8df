"""Terrain: its heights, where they are, and how it is drawn and driven on."""
import xml.etree.ElementTree as ElementTree

import numpy as np
import pybullet
import pytest
from PIL import Image

from img_recog.formats import heightmaps, still_images, world_file
from img_recog.formats.meshes import mesh_file
from img_recog.model import BOX, HEIGHTMAP, Material, Shape
from img_recog.simulation.physics.client import connect
from img_recog.simulation.physics.solids import Bundles
from img_recog.simulation.physics.world import World
from img_recog.simulation.pictures import footprints
from img_recog.simulation.simulation_settings import PhysicsSettings
from img_recog_helpers.refusals import refusal
from img_recog_helpers.sdf import sdf

# the upper row is that of the largest y; the brightest pixel has the height of <size>
PIXELS = np.array([[0, 50, 100, 50, 0], [50, 150, 200, 50, 0], [0, 50, 100, 20, 0]], np.uint8)
TERRAIN = ('<model name="hills"><static>1</static><pose>10 20 1 0 0 0</pose><link name="l">'
           '<{0} name="s"><geometry><heightmap><uri>{1}</uri><size>8 4 {2}</size>'
           '<pos>1 2 0.5</pos>{3}</heightmap></geometry></{0}></link></model>')


@pytest.fixture
def hills(tmp_path):
    """A function that reads a world with a heightmap."""
    def read(size=2, tag='collision', inside='', pixels=PIXELS, mode=None):
        Image.fromarray(pixels, mode).save(str(tmp_path / 'hills.png'))
        path = tmp_path / 'hall.world'
        path.write_text(sdf(TERRAIN.format(tag, 'hills.png', size, inside)))
        return world_file.read(str(path), {})
    return read


def build(file):
    return World(PhysicsSettings(), file, connect())


def heights(world, x, y):
    """Return the height in the world below points."""
    found = pybullet.rayTestBatch(
        [(*point, 50) for point in zip(x, y)], [(*point, -50) for point in zip(x, y)],
        physicsClientId=world.physics_client_id)
    return np.array([hit[3][2] for hit in found])


def grid(rows, columns):
    """Return x and y of the points of a grid over the terrain, a little within its edge."""
    x, y = np.meshgrid(np.linspace(-4, 4, columns), np.linspace(2, -2, rows))
    return (0.99999 * x + 11).ravel(), (0.99999 * y + 22).ravel()


@pytest.mark.parametrize('sampling', [1, 3])
def test_the_heights_are_where_gazebo_has_them(hills, sampling):
    world = build(hills(inside='<sampling>{}</sampling>'.format(sampling)))
    assert [body.name for body in world.scenery] == ['hills', 'hills::l::s']
    found = heights(world, *grid(3, 5)).reshape(3, 5)
    assert found == pytest.approx(PIXELS / 200 * 2 + 1.5, abs=2e-3)
    if sampling == 3:       # between pixels, bilinear
        middle = heights(world, [11 - 4 + 2 * (1 + 1 / 3)], [22 + 2 - 2 / 3])
        row = PIXELS[0] + (PIXELS[1].astype(float) - PIXELS[0]) / 3
        assert middle == pytest.approx((row[1] + (row[2] - row[1]) / 3) / 100 + 1.5, abs=2e-3)


@pytest.mark.parametrize('pixels, mode, size, expected', [
    (PIXELS.astype(np.uint16) * 257, 'I;16', 2, PIXELS / 127.5),
    (np.stack([255 - PIXELS, PIXELS, PIXELS], axis=2), 'RGB', 2, PIXELS / 100),
    (PIXELS * 0, None, 2, PIXELS * 0.0), (PIXELS, None, -2, 1 - PIXELS / 100),
    (PIXELS, None, 0, PIXELS * 0.0)])
def test_kinds_of_images(hills, pixels, mode, size, expected):
    world = build(hills(size, pixels=pixels, mode=mode))
    assert heights(world, *grid(3, 5)) == pytest.approx(expected.ravel() + 1.5, abs=2e-3)


@pytest.mark.parametrize('pixel, others, height', [
    (100, [], 1), (100, [200], 0.5), (100, [1], 0.3922), (100, [1, 200], 0.3922),
    (100, [2, 0], 1), (1, [], 0.0039), ((100, 150, 50), [], 1),
    ((100, 150, 50), [(200, 20, 90)], 0.5556), ((100, 150, 50), [(20, 200, 90)], 0.5556),
    ((100, 150, 50), [(1, 1, 1)], 0.1961), ((100, 150, 50), [(1, 0, 0)], 1),
    ((100, 150, 50), [(0, 0, 1)], 1)])
def test_which_pixel_has_the_whole_height_in_gazebo(tmp_path, pixel, others, height):
    pixels = np.full((17, 17, *np.shape(pixel)), pixel, np.uint8)
    for column, other in enumerate(others):
        pixels[0, column] = other
    Image.fromarray(pixels).save(str(tmp_path / 'flat.png'))
    shape = Shape(HEIGHTMAP, (6.0, 6.0, 1.0, 2), str(tmp_path / 'flat.png'))
    assert heightmaps.read(shape).heights[16, 16] == pytest.approx(height, abs=1e-4)


def test_rays_of_sensors_meet_it(hills):
    world = build(hills())
    down = Bundles(np.array([[11.0, 22, 9]]), np.array([[[0, 0, -1.0]]]), np.array([0.0]),
                   np.array([20.0]))
    assert world.solids.distances(down)[1]          # so they are PyBullet's
    assert footprints.footprints(world) == []
    world.remove(world.models[-1])
    distances, has_others = world.solids.distances(down)
    assert not has_others and distances[0, 0] == np.inf


def test_it_is_drawn_as_a_mesh(hills, tmp_path):
    file = hills(tag='visual')
    visual, = file.trees[0].model.links[0].looks
    assert visual.pose.translation == pytest.approx([1, 2, 0.5])
    assert visual.material.color == pytest.approx((0.42, 0.4, 0.32, 1)) and len(file.trees) == 1
    part, = mesh_file.read(visual.shape.path)
    corners = part.positions.reshape(-1, 3)
    assert corners.min(axis=0) == pytest.approx([-4, -2, 0])
    assert corners.max(axis=0) == pytest.approx([4, 2, 2])
    top = corners[corners[:, 2].argmax()]
    assert top == pytest.approx([0, 0, 2])
    assert part.uvs == pytest.approx(part.positions[:, :, :2] / (8, 4) + 0.5)
    assert np.cross(part.positions[:, 1] - part.positions[:, 0],
                    part.positions[:, 2] - part.positions[:, 0])[:, 2].min() > 0


def test_its_first_texture_is_repeated(hills, tmp_path):
    Image.new('RGB', (2, 2)).save(str(tmp_path / 'grass.png'))
    texture = '<texture><size>2</size><diffuse>{}</diffuse><normal>n.png</normal></texture>'
    file = hills(tag='visual', inside=texture.format('grass.png') + texture.format('none.png'))
    visual, = file.trees[0].model.links[0].looks
    assert visual.material.texture == str(tmp_path / 'grass.png')
    assert visual.material.scale == (0.25, 0.5)


@pytest.mark.parametrize('pixels, sampling, points', [
    (129, 4, 513), (257, 4, 257), (1025, 2, 1025), (2049, 1, 1025)])
def test_large_images_have_fewer_points(tmp_path, pixels, sampling, points):
    Image.new('L', (pixels, 2), 7).save(str(tmp_path / 'a.png'))
    shape = Shape(HEIGHTMAP, (1.0, 1.0, 1.0, sampling), str(tmp_path / 'a.png'))
    assert heightmaps.read(shape).heights.shape[1] == points


def test_what_cannot_be_read_is_named(hills, tmp_path):
    assert 'not supported: heightmap none.png' in refusal(
        world_file.read, write(tmp_path, TERRAIN.format('collision', 'none.png', 2, '')), {})
    (tmp_path / 'a.tif').write_bytes(b'II')
    assert 'heightmap {}: '.format(tmp_path / 'a.tif') in refusal(
        world_file.read, write(tmp_path, TERRAIN.format('visual', 'a.tif', 2, '')), {})


def write(folder, model):
    (folder / 'w.world').write_text(sdf(model))
    return str(folder / 'w.world')


def test_the_shapes_after_a_heightmap_are_there_too(hills, tmp_path):
    hills()
    text = TERRAIN.format('collision', 'hills.png', 2, '').replace('</link>', (
        '<collision name="b"><geometry><box><size>1 2 3</size></box></geometry></collision>'
        '</link>'))
    model, terrain = world_file.read(write(tmp_path, text), {}).trees
    assert [solid.shape for solid in model.model.links[0].solids] == [Shape(BOX, (1, 2, 3))]
    assert model.model.terrain is None
    assert (terrain.name, terrain.fixed, terrain.first) == ('hills::l::s', True, False)
    link, = terrain.model.links
    assert link.name == 'link0' and terrain.model.terrain == link.solids[0].shape
    assert terrain.in_model.translation == pytest.approx((1, 2, 1.5))
    assert terrain.pose.translation == pytest.approx((11, 22, 2.5))


def element_of(inside):
    return ElementTree.fromstring('<heightmap>{}</heightmap>'.format(inside))


@pytest.mark.parametrize('inside, size, sampling, position', [
    ('', (1, 1, 1), 2, [0, 0, 0]), ('<sampling>0</sampling>', (1, 1, 1), 1, [0, 0, 0]),
    ('<size>3 4 -5</size><pos>1 2 3</pos><sampling>3</sampling>', (3, 4, -5), 3, [1, 2, 3])])
def test_what_an_sdf_may_omit(tmp_path, inside, size, sampling, position):
    path = str(tmp_path / 'a.png')
    Image.fromarray(PIXELS).save(path)
    made, pose = heightmaps.shape(
        'a', element_of('<uri> a.png </uri>' + inside), {'a.png': path}.get)
    assert made == Shape(HEIGHTMAP, (*size, sampling), path)
    assert pose.translation.tolist() == position
    assert refusal(heightmaps.shape, 'a', element_of(''), lambda uri: None) == 'heightmap '


@pytest.mark.parametrize('size', ['0 4 2', '8 0 2', '-8 4 2'])
def test_a_size_above_0_is_expected(tmp_path, size):
    Image.fromarray(PIXELS).save(str(tmp_path / 'a.png'))
    element = element_of('<uri>a</uri><size>{}</size>'.format(size))
    assert refusal(heightmaps.shape, 'a', element, lambda uri: str(
        tmp_path / 'a.png')) == '<size> of a: got {!r}, expected more than 0'.format(size)


@pytest.mark.parametrize('size, words', [
    ((1, 5), '1x5 pixels, expected 2 to 50000000 in all, on a side 2 or more;'),
    ((5, 1), '5x1 pixels, expected 2 to 50000000 in all, on a side 2 or more;'),
    ((10000, 5001), '10000x5001 pixels, expected 2 to 50000000 in all, on a side 2 or more;')])
def test_images_of_a_wrong_size_are_refused(tmp_path, size, words):
    path = str(tmp_path / 'a.png')
    Image.new('1', size).save(path)
    assert 'heightmap {}: {}'.format(path, words) in refusal(
        heightmaps.shape, 'a', element_of('<uri>a</uri>'), lambda uri: path)
    assert refusal(heightmaps.read, Shape(HEIGHTMAP, (1, 1, 1, 1))).startswith('heightmap : ')


def test_an_image_above_the_limit_of_pillow_has_the_same_message(tmp_path, monkeypatch):
    path = str(tmp_path / 'a.png')
    Image.new('1', (20000, 10000)).save(path)
    monkeypatch.setattr(Image, 'MAX_IMAGE_PIXELS', 89478485)        # that of a new process
    still_images.pillow.cache_clear()
    assert 'heightmap {}: 20000x10000 pixels, expected 2 to'.format(path) in refusal(
        heightmaps.shape, 'a', element_of('<uri>a</uri>'), lambda uri: path)


@pytest.mark.parametrize('mode', ['I', 'I;16B', 'I;16', 'L', 'F'])
def test_images_of_one_channel_keep_their_steps(tmp_path, mode):
    values, white = (np.array([[0, 51], [102, 204]]), 204) if mode in 'LF' else (
        np.array([[0, 1000], [300, 65535]]), 65535)
    types = {'I': '<i4', 'I;16B': '>u2', 'I;16': '<u2', 'L': 'u1', 'F': '<f4'}
    Image.frombytes(mode, (2, 2), values.astype(types[mode]).tobytes()).save(
        str(tmp_path / 'a.tif'))
    found = heightmaps.read(Shape(HEIGHTMAP, (3, 4, 2, 1), str(tmp_path / 'a.tif')))
    assert found.heights == pytest.approx(values[::-1] * 2 / white)
    assert found.size == (3, 4) and found.middle == pytest.approx(1)


def test_a_mesh_of_many_points_is_drawn_with_fewer(tmp_path):
    Image.fromarray(np.tile(np.arange(200, dtype=np.uint8), (2, 1))).save(str(tmp_path / 'a.png'))
    part, = mesh_file.read(heightmaps.write_mesh(
        Shape(HEIGHTMAP, (8, 4, 2, 2), str(tmp_path / 'a.png'))))
    corners = part.positions.reshape(-1, 3)
    assert len(np.unique(corners[:, 0])) == 257 and len(np.unique(corners[:, 1])) == 3
    assert corners[:, 2] == pytest.approx((corners[:, 0] + 4) / 4 * 199 / 255, abs=1e-5)


@pytest.mark.parametrize('inside, scale', [
    ('<texture><diffuse> a </diffuse></texture>', (10, 10)),
    ('<size>4 2 1</size><texture><diffuse>a</diffuse><size>0</size></texture>', (1, 1)),
    ('<size>4 2 1</size><texture><diffuse>a</diffuse><size>3</size></texture>', (0.75, 1.5))])
def test_the_size_of_a_texture(tmp_path, inside, scale):
    path = str(tmp_path / 'a.png')
    (tmp_path / 'a.png').write_text('')
    assert heightmaps.material(element_of(inside), {'a': path}.get) == Material(
        (1, 1, 1, 1), path, scale)
    assert heightmaps.material(element_of(inside), lambda uri: path + 'x').texture == ''
    assert heightmaps.material(element_of(inside), lambda uri: None).texture == ''
