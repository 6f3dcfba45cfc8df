"""Images by TinyRenderer: the same as by OpenGL, but for shadows, the floor and edges."""
import math

import numpy as np
import pytest
from PIL import Image

from img_recog.model import (BOX, CYLINDER, MESH, PLANE, SPHERE, Light, Material, Shape, Visual,
                             VisualScene)
from img_recog.rendering.camera import Camera
from img_recog.rendering.opengl import Renderer
from img_recog.simulation.pictures.tiny_renderer import TinyRenderer
from img_recog_testing.drawn import at

CAMERA = Camera(160, 120, math.radians(60), 0.05, 50.0)
LIGHT = Light((0.5, -0.1, 0.9), (0.7, 0.7, 0.7), floor=False)
OBJ = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'
POSES = np.array([[0.0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, math.sin(0.1), math.cos(0.1)]])


def visual(shape, pose, color=(0.2, 0.5, 0.9, 1.0), part=0, texture=''):
    return Visual(part, shape, pose, Material(color, texture))


def scene(*visuals):
    return VisualScene(tuple(visuals), (False, True), LIGHT)


def loaded(make, content):
    renderer = make()
    assert renderer.load(content, POSES) == []
    return renderer


@pytest.mark.parametrize('shape', [
    Shape(BOX, (1.0, 1.5, 0.7)), Shape(CYLINDER, (0.5, 1.2)), Shape(SPHERE, (0.6,)),
    Shape(PLANE, (1.5, 1.5)), Shape(MESH, (1.5, 1.5, 1.5), 'a.obj')])
@pytest.mark.parametrize('part', [0, 1])
def test_images_are_like_those_by_opengl(tmp_path, shape, part):
    if shape.path:
        (tmp_path / 'a.obj').write_text(OBJ)
        shape = shape._replace(path=str(tmp_path / 'a.obj'))
    content = scene(visual(shape, at(3, 0.2, -0.8), part=part))
    tiny, opengl = loaded(TinyRenderer, content), loaded(Renderer, content)
    pose = at(0, 0, 0)
    images = [each.draw(CAMERA, pose, POSES).astype(int) for each in (tiny, opengl)]
    assert images[0].shape == (120, 160, 3)
    covered = [np.abs(image - (178, 178, 178)).max(axis=2) > 20 for image in images]
    assert covered[1].sum() > 300
    # they differ at edges alone
    assert (covered[0] ^ covered[1]).sum() < 0.08 * covered[1].sum() + 60


def test_depths_are_like_those_by_opengl():
    content = scene(visual(Shape(BOX, (1.0, 1.5, 0.7)), at(3, 0.2, 0)))
    tiny, opengl = (loaded(make, content).depth(CAMERA, at(0, 0, 0), POSES)
                    for make in (TinyRenderer, Renderer))
    assert tiny.dtype == np.float32 and tiny[60, 80] == pytest.approx(2.5, abs=0.01)
    both = np.isfinite(tiny) & np.isfinite(opengl)
    assert np.abs(tiny[both] - opengl[both]).max() < 0.02
    assert np.isinf(tiny[0, 0]) and (np.isinf(tiny) ^ np.isinf(opengl)).mean() < 0.02


def test_a_point_is_drawn_where_the_intrinsics_project_it():
    image = loaded(TinyRenderer, scene(visual(Shape(SPHERE, (0.1,)), at(4, 1.2, -0.8)))).draw(
        CAMERA, at(0, 0, 0), POSES)
    rows, columns = np.nonzero(np.abs(image.astype(int) - 178).max(axis=2) > 20)
    fx, fy, cx, cy = CAMERA.intrinsics
    assert (columns.mean(), rows.mean()) == pytest.approx((cx - fx * 0.3, cy + fy * 0.2), abs=0.5)


def test_a_texture(tmp_path):
    path = tmp_path / 'a.png'
    Image.new('RGB', (8, 8), (255, 0, 0)).save(str(path))
    content = scene(visual(Shape(BOX, (1, 1, 1)), at(3, 0, 0), (1.0, 1.0, 1.0, 1.0),
                           texture=str(path)))
    image = loaded(TinyRenderer, content).draw(CAMERA, at(0, 0, 0), POSES)
    red, green, blue = image[60, 80].tolist()
    assert red > 150 and green == blue == 0


def test_what_cannot_be_read_is_named_and_the_rest_is_drawn(tmp_path):
    mesh, texture = str(tmp_path / 'none.stl'), str(tmp_path / 'none.png')
    renderer = TinyRenderer()
    assert renderer.load(scene(
        visual(Shape(MESH, (1, 1, 1), mesh), at(3, 0, 0)),
        visual(Shape(BOX, (1, 1, 1)), at(3, 0, 0), (1.0, 0.0, 0.0, 1.0), texture=texture)),
        POSES) == ['cannot read the mesh {}: No such file or directory; give a DAE, OBJ or STL '
                   'file that is complete'.format(mesh), 'there is no file ' + texture]
    red, green, blue = renderer.draw(CAMERA, at(0, 0, 0), POSES)[60, 80].tolist()
    assert red > 150 and green == blue == 0


def test_another_scene_takes_the_place_of_the_first():
    renderer = loaded(TinyRenderer, scene(visual(Shape(BOX, (1, 1, 1)), at(3, 1, 0))))
    assert renderer.load(scene(visual(Shape(BOX, (1, 1, 1)), at(3, -1, 0))), POSES) == []
    covered = np.abs(renderer.draw(CAMERA, at(0, 0, 0), POSES).astype(int) - 178).max(axis=2) > 20
    assert not covered[:, :80].any() and covered[:, 80:].any()
