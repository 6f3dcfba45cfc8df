"""Images by OpenGL: where things are, and what color they have."""
import math
import os

import numpy as np
import pytest
from PIL import Image

from img_recog.model import (BOX, CYLINDER, MESH, PLANE, SPHERE, Material, Shape, Surroundings,
                             Visual)
from img_recog.rendering import matrices
from img_recog.rendering.camera import Camera
from img_recog.rendering.opengl import Renderer
from img_recog_helpers.drawn import (BACKGROUND, BLUE, CAMERA, GREEN, HERE, RED, at, centroid,
                                     draw, loaded, looking_down, renderer_of_all, scene, sky_color,
                                     visual)

SKY = Surroundings(background=BACKGROUND, has_sky=True)
# a camera that is turned about all axes
TURNED = matrices.from_poses(np.array([[1.0, -2.0, 0.5, *(
    np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9]))]]))[0]


@pytest.mark.parametrize('pose', [np.eye(4), looking_down(5.0), TURNED],
                         ids=['forward', 'down', 'turned'])
@pytest.mark.parametrize('point', [(4.0, 0.0, 0.0), (4.0, 1.5, 1.0), (6.0, -2.5, -1.5)])
@pytest.mark.parametrize('size', [(320, 240), (321, 200)])
def test_a_point_is_drawn_where_the_intrinsics_project_it(pose, point, size):
    camera = Camera(*size, math.radians(62.2))
    image = draw(visual(Shape(SPHERE, (0.05,)), pose @ at(*point), RED), camera=camera, pose=pose)
    fx, fy, cx, cy = camera.intrinsics
    forward, left, up = point
    expected = cx - fx * left / forward, cy - fy * up / forward
    assert centroid(image) == pytest.approx(expected, abs=0.15)


def test_background_and_colors():
    image = draw(visual(Shape(BOX, (1, 1, 1)), at(5, 0, 0), BLUE))
    assert image[0, 0].tolist() == [128, 64, 191]
    # it faces the camera, and the sun passes by
    assert image[120, 160].tolist() == pytest.approx([0, 0, 178], abs=1)
    bright = draw(visual(Shape(BOX, (1, 1, 1)), at(5, 0, 0), (0.0, 0.0, 1.0, 2.0)))
    assert np.array_equal(image, bright)        # as files may have them


def test_edges_are_antialiased():
    image = draw(visual(Shape(BOX, (0.1, 2, 2)), matrices.from_poses(
        np.array([[5.0, 0, 0, math.sin(0.1), 0, 0, math.cos(0.1)]]))[0], BLUE))
    colors = {tuple(color) for color in image.reshape(-1, 3)}
    between = [color for color in colors if 5 < color[0] < 120]
    assert len(between) >= 3


@pytest.mark.parametrize('prefers_file, has_material, color', [
    (False, True, (255, 0, 0)), (True, True, (0, 255, 0)), (True, False, (255, 0, 0))])
def test_whose_material_counts(tmp_path, prefers_file, has_material, color):
    (tmp_path / 'a.mtl').write_text('newmtl m\nKa 0 1 0\nKd 0 1 0\n')
    (tmp_path / 'a.obj').write_text((
        'mtllib a.mtl\nusemtl m\n' if has_material else '') + 'v 1 -1 -1\nv 1 1 -1\nv 1 0 2\n'
        'f 3 2 1\n')
    mesh = Visual(0, Shape(MESH, (1.0, 1.0, 1.0), str(tmp_path / 'a.obj')), np.eye(4),
                  Material(RED), prefers_file)
    image = draw(mesh, sun=(-1.0, 0.0, 0.0))
    assert image[120, 160].tolist() == list(color)


def test_a_transparent_face_shows_what_is_behind():
    image = draw(visual(Shape(PLANE, (2, 2)), at(0, 0, 0), GREEN),
                 visual(Shape(PLANE, (2, 2)), at(0, 0, 1), (1.0, 0.0, 0.0, 0.5)),
                 pose=looking_down(4.0))
    assert image[120, 160].tolist() == pytest.approx([128, 128, 0], abs=2)
    assert draw(visual(Shape(PLANE, (2, 2)), at(0, 0, 0), (1.0, 0, 0, 0.0)),
                pose=looking_down(4.0))[120, 160].tolist() == [128, 64, 191]


@pytest.mark.parametrize('shape', [
    Shape(BOX, (2, 2, 2)), Shape(CYLINDER, (1, 2)), Shape(SPHERE, (1,))],
    ids=lambda shape: shape.kind)
def test_the_inside_of_a_closed_shape_is_not_drawn(shape):
    wall = visual(Shape(BOX, (1, 9, 9)), at(6, 0, 0), BLUE)
    renderer = loaded(scene(visual(shape, np.eye(4), RED), wall), HERE)
    red, green, blue = renderer.draw(CAMERA, np.eye(4), HERE)[120, 160].tolist()
    assert red == green == 0 and blue > 150
    assert renderer.depth(CAMERA, np.eye(4), HERE)[120, 160] == pytest.approx(5.5, abs=1e-3)
    # and all of it from outside
    red, green, blue = renderer.draw(CAMERA, at(-4, 0, 0), HERE)[120, 160].tolist()
    assert red > 100 and green == blue == 0
    assert renderer.depth(CAMERA, at(-4, 0, 0), HERE)[120, 160] == pytest.approx(3.0, abs=0.01)


@pytest.mark.parametrize('heights', [(0, 1), (1, 0)])
def test_transparent_faces_are_seen_through_in_any_order(tmp_path, heights):
    path = tmp_path / 'two.obj'
    path.write_text(''.join('v -1 -1 {0}\nv 1 -1 {0}\nv 0 1 {0}\n'.format(height)
                            for height in heights) + 'f 1 2 3\nf 4 5 6\n')
    image = draw(visual(Shape(MESH, (1, 1, 1), str(path)), np.eye(4), (1.0, 0, 0, 0.5)),
                 pose=looking_down(4.0))
    assert image[120, 160].tolist() == pytest.approx([255 * 0.75 + 128 * 0.25, 16, 48], abs=3)


def test_the_far_side_of_a_transparent_shape_is_not_drawn():
    half = visual(Shape(BOX, (2, 2, 2)), np.eye(4), (1.0, 0.0, 0.0, 0.5))
    assert draw(half)[120, 160].tolist() == [128, 64, 191]      # from inside
    assert draw(half, pose=at(-4, 0, 0))[120, 160].tolist() == pytest.approx(
        [64 + 0.7 * 128, 32, 96], abs=2)


@pytest.mark.parametrize('texture', ['', 'a.png'])
def test_a_face_is_drawn_from_its_front_alone(tmp_path, texture):
    path, image = tmp_path / 'half.obj', texture and str(tmp_path / texture)
    Image.new('RGB', (8, 8), (255, 255, 255)).save(str(tmp_path / 'a.png'))
    path.write_text('v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nf 1 2 3\nf 1 3 4\n')
    behind = matrices.from_poses(np.array([[4.0, 0, 0, 0, 0, 1, 0]]))[0]
    # a mirrored face stays a front
    for scale, (front, back) in ((1, (behind, at(-4, 0, 0))), (-1, (at(-4, 0, 0), behind))):
        renderer = loaded(scene(visual(Shape(MESH, (scale, 1, 1), str(path)), np.eye(4), RED,
                                       texture=image)), HERE)
        red, _, blue = renderer.draw(CAMERA, front, HERE)[120, 160].tolist()
        assert red > 100 and blue == 0
        assert renderer.draw(CAMERA, back, HERE)[120, 160].tolist() == [128, 64, 191]


def test_of_a_face_and_its_back_at_the_same_place_the_front_is_seen(tmp_path):
    (tmp_path / 'a.mtl').write_text('newmtl front\nKa 0 1 0\nnewmtl back\nKa 1 0 0\n')
    (tmp_path / 'a.obj').write_text(
        'mtllib a.mtl\nv 0 -1 -1\nv 0 1 -1\nv 0.7 1.1 1\nv 0.7 -0.9 1\nusemtl front\n'
        'f 4 3 2 1\nusemtl back\nf 1 2 3 4\n')
    mesh = Visual(0, Shape(MESH, (1, 1, 1), str(tmp_path / 'a.obj')), np.eye(4))
    image = draw(mesh, pose=at(-4, 0, 0))
    assert image[120, 160, 1] > 100 and not ((image[:, :, 0] > 150) & (image[:, :, 1] < 50)).any()


def test_of_a_scene_of_many_shapes_each_image_is_that_of_all(tmp_path):
    """What is not on the image is not drawn: no shape at its edge may be lost."""
    boxes = [visual(Shape(BOX, (0.4, 0.4, 0.4)), at(3 * math.cos(angle), 3 * math.sin(angle), up),
                    color) for angle in np.arange(0, 2 * math.pi, 1.0)
             for up, color in ((-0.6, RED), (0.6, BLUE))]
    poses = matrices.from_poses(np.array([
        [0.3, 0, 0, 0, 0, math.sin(angle / 2), math.cos(angle / 2)] for angle in (0.2, 2.5, 4.4)]))

    def seen_of(*shapes):
        renderer = loaded(scene(*shapes), HERE)
        return ([renderer.draw(CAMERA, pose, HERE) for pose in poses],
                np.array([renderer.depth(CAMERA, pose, HERE) for pose in poses]))
    images, all_depths = seen_of(*boxes)
    assert np.array_equal(all_depths, np.min([seen_of(box)[1] for box in boxes], axis=0))
    for image, empty, depths in zip(images, seen_of()[0], all_depths):
        seen = (image != empty).any(axis=2)
        assert seen[np.isfinite(depths)].mean() > 0.97 and np.isfinite(depths).any()


def test_what_is_above_a_ceiling_is_not_drawn():
    wall, roof = (visual(Shape(BOX, size), at(*place), color) for size, place, color in (
        ((2, 2, 3), (0, 2, 1.5), GREEN), ((9, 9, 0.2), (0, 0, 3), RED)))
    renderer = loaded(scene(wall, roof, visual(Shape(BOX, (1, 1, 1)), at(0, 0, 0.5), BLUE)), HERE)
    down = looking_down(10.0)
    for ceiling, color in ((np.inf, 0), (2.9, 2), (0.0, None), (np.inf, 0)):
        image = renderer.draw(CAMERA, down, HERE, ceiling)[120, 160].tolist()
        expected = [128, 64, 191] if color is None else [255 * (color == n) for n in range(3)]
        assert image == pytest.approx(expected, abs=2), ceiling
    # a tall wall is cut, and the rest of it is seen
    forward = renderer.draw(CAMERA, at(-6, 2, 1.5), HERE, 1.5)
    assert forward[110, 160].tolist() == [128, 64, 191] and forward[130, 160, 1] > 100


@pytest.mark.parametrize('distance, expected', [
    (0.5, math.inf), (1.5, 1.5), (3.0, 3.0), (9.0, 9.0), (11.0, math.inf)])
def test_depths_along_the_optical_axis_between_near_and_far(distance, expected):
    camera = CAMERA._replace(near=1.0, far=10.0)
    renderer = loaded(scene(visual(Shape(BOX, (0.2, 40, 40)), at(distance + 0.1, 0, 0), RED)),
                      HERE)
    depths = renderer.depth(camera, np.eye(4), HERE)
    assert depths.dtype == np.float32 and depths.shape == (240, 320)
    np.testing.assert_allclose(depths, expected, rtol=1e-4)
    image = renderer.draw(camera, np.eye(4), HERE)
    assert (image[:, :, 1] == 0).all() if expected < math.inf else (image[:, :, 1] == 64).all()


def test_of_several_parts_one_that_is_not_seen_leaves_out_no_other():
    boxes = [visual(Shape(BOX, (1, 1, 1)), np.eye(4), color, part)
             for part, color in enumerate((RED, GREEN, BLUE))]
    poses = np.concatenate([HERE] * 3)
    poses[:, 0] = -5, 5, -5
    red, green, blue = draw(*boxes, poses=poses, moving=(True,) * 3)[120, 160].tolist()
    assert green > 100 and red == blue == 0


def test_another_scene_takes_the_place_of_the_first():
    left = scene(visual(Shape(BOX, (1, 1, 1)), at(3, 1, 0), RED), floor=True)
    poses = np.array([[0, 0, 0, 0, 0, 0, 1.0], [3, -1, 0, 0, 0, 0, 1]])
    right = scene(visual(Shape(BOX, (1, 1, 1)), np.eye(4), GREEN, part=1), floor=True,
                  moving=(False, True))
    renderer = Renderer()
    renderer.load(left, HERE)
    before = renderer.draw(CAMERA, at(0, 0, 0.5), HERE)
    assert renderer.load(right, poses) == []
    image = renderer.draw(CAMERA, at(0, 0, 0.5), poses)
    assert np.array_equal(image, loaded(right, poses).draw(CAMERA, at(0, 0, 0.5), poses))
    renderer.load(left, HERE)
    assert np.array_equal(renderer.draw(CAMERA, at(0, 0, 0.5), HERE), before)


def test_what_cannot_be_read_is_named_once_and_the_rest_is_drawn(tmp_path):
    mesh, texture = tmp_path / 'cut.stl', tmp_path / 'cut.png'
    mesh.write_bytes(b'solid')
    texture.write_bytes(b'no image')
    renderer = renderer_of_all()
    broken = visual(Shape(MESH, (1, 1, 1), str(mesh)), at(3, 0, 0), RED)
    missing = renderer.load(scene(
        broken, broken, visual(Shape(BOX, (1, 1, 1)), at(3, 0, 0), RED, texture=str(texture))),
        HERE)
    assert len(missing) == 2, missing
    assert missing[0].startswith('cannot read the mesh {}: '.format(mesh))
    assert missing[1].startswith('cannot read the texture {}: '.format(texture))
    red, green, blue = renderer.draw(CAMERA, at(0, 0, 0), HERE)[120, 160].tolist()
    assert red > 150 and green == blue == 0


def test_a_texture_that_has_changed_is_drawn_anew(tmp_path):
    path, images = tmp_path / 'a.png', []
    content = scene(visual(Shape(BOX, (1, 4, 4)), at(3, 0, 0), (1.0, 1.0, 1.0, 1.0),
                           texture=str(path)))
    renderer = renderer_of_all()
    for time, color in enumerate([(255, 0, 0), (0, 0, 255), (0, 0, 255)]):
        Image.new('RGB', (8, 8), color).save(str(path))
        os.utime(str(path), (time, time))
        assert renderer.load(content, HERE) == []
        images.append(renderer.draw(CAMERA, np.eye(4), HERE)[120, 160])
    assert images[0][0] > 100 and images[0][2] == 0
    assert images[1][2] > 100 and images[1][0] == 0 and np.array_equal(images[1], images[2])


def test_a_texture_is_upright_and_not_mirrored(tmp_path):
    colors = [[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 0)]]     # rows from the top
    Image.fromarray(np.array(colors, np.uint8).repeat(8, 0).repeat(8, 1)).save(
        str(tmp_path / 'a.png'))
    image = draw(visual(Shape(BOX, (1, 2, 2)), at(4, 0, 0), (1.0, 1.0, 1.0, 1.0),
                        texture=str(tmp_path / 'a.png')))
    seen = [[image[row, column] > 90 for column in (140, 180)] for row in (100, 140)]
    assert np.array_equal(seen, np.array(colors) > 0)


def test_the_sky_is_behind_everything():
    box = visual(Shape(BOX, (1, 1, 1)), at(3, 0, 0), GREEN)
    renderer = loaded(scene(box, around=SKY), HERE)
    image = renderer.draw(CAMERA, np.eye(4), HERE)
    assert image[120, 160].tolist() == [0, 102, 0]      # the box
    assert image[0, 160] == pytest.approx(
        sky_color((math.sqrt(0.8125), 0, math.sqrt(0.1875))), abs=10)
    assert image[239, 160].tolist() == [128, 64, 191]       # the background, below the horizon
    assert np.isinf(renderer.depth(CAMERA, np.eye(4), HERE)[0, 160])


def test_the_whole_sky_is_drawn_in_all_directions_of_the_camera():
    renderer = loaded(scene(around=SKY), HERE)
    intrinsics = CAMERA.intrinsics
    rows, columns = np.mgrid[:CAMERA.height, :CAMERA.width]
    rays = np.stack([np.ones(rows.shape), (intrinsics.cx - columns) / intrinsics.fx,
                     (intrinsics.cy - rows) / intrinsics.fy], axis=2)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    turns = np.random.RandomState(3).standard_normal((4, 4))
    level = [(0, 0, 0, 1), (0, math.sqrt(0.5), 0, math.sqrt(0.5)),
             (0, -math.sqrt(0.5), 0, math.sqrt(0.5)), (math.sqrt(0.5), 0, 0, math.sqrt(0.5)),
             (1, 0, 0, 0)]
    for turn in [*level, *(turns / np.linalg.norm(turns, axis=1, keepdims=True))]:
        pose = matrices.from_poses(np.array([[1.0, -2.0, 0.5, *turn]]))[0]
        expected = sky_color(rays @ pose[:3, :3].T, (128, 64, 191))
        assert np.abs(renderer.draw(CAMERA, pose, HERE) - expected).max() < 2, turn


@pytest.mark.parametrize('height, z, is_seen', [
    (3, -0.5, False), (3, 0.5, True), (-3, 0.5, False), (-3, -0.5, True),
    (-0.9, 0.5, False)])
def test_the_floor_hides_what_is_on_its_other_side(height, z, is_seen):
    pose = looking_down(height)
    if height < 0:
        pose[:3, :3] = [[0, 0, -1], [0, 1, 0], [1, 0, 0]]
    image = draw(visual(Shape(BOX, (0.4, 0.4, 0.4)), at(0, 0, z), RED), pose=pose, floor=True)
    red = (image[:, :, 0] > 100) & (image[:, :, 1] < 50)
    assert red.any() == is_seen and red[120, 160] == is_seen
