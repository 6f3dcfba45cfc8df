"""Meshes of an SDF are drawn with the materials that the SDF gives them."""
import numpy as np
import pytest
from PIL import Image

from img_recog.formats import world_file
from img_recog.model import MESH, Material, Shape, Visual
from img_recog_helpers.drawn import draw, looking_down

COLLADA = '''<COLLADA version="1.4.1" xmlns="http://www.collada.org/2005/11/COLLADASchema">
<library_geometries><geometry id="g"><mesh><source id="x"><float_array count="12">
-1 -1 0 1 -1 0 1 1 0 -1 1 0</float_array><technique_common><accessor count="4" stride="3"/>
</technique_common></source><source id="t"><float_array count="8">0 0 1 0 1 1 0 1</float_array>
<technique_common><accessor count="4" stride="2"/></technique_common></source><vertices id="v">
<input semantic="POSITION" source="#x"/></vertices><triangles count="2"><input semantic="VERTEX"
source="#v" offset="0"/><input semantic="TEXCOORD" source="#t" offset="1"/>
<p>0 0 1 1 2 2 0 0 2 2 3 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
'''
MODEL = '''<sdf version="1.6"><model name="m"><static>1</static><link name="l"><visual name="v">
<geometry><mesh><uri>a.dae</uri></mesh></geometry>{}</visual></link></model></sdf>'''
SCRIPT = ('<material><script><uri>materials/scripts</uri><uri>materials/textures</uri>'
          '<name>{}</name></script></material>')


@pytest.fixture
def seen(tmp_path):
    """A function that draws what an SDF puts into the <visual> of a square of 2 m, from above.

    It returns the colors at places x, y on the square.
    """
    for name in ('scripts', 'textures'):
        (tmp_path / 'materials' / name).mkdir(parents=True)
    # blue on the left; x is upward in the image of a camera that looks down
    Image.fromarray(np.array([[(0, 0, 255), (255, 0, 0)]] * 2, np.uint8).repeat(
        8, axis=0).repeat(8, axis=1)).save(str(tmp_path / 'materials' / 'textures' / 'a.png'))
    (tmp_path / 'materials' / 'scripts' / 'a.material').write_text(
        'material Sign/Whole { technique { pass { texture_unit { texture a.png } } } }\n'
        'material Sign/Half { technique { pass { texture_unit { texture a.png scale 0.5 1 } } } }')
    (tmp_path / 'a.dae').write_text(COLLADA)
    (tmp_path / 'a.obj').write_text('v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n')

    def colors(inside, *places, mesh='a.dae'):
        (tmp_path / 'm.sdf').write_text(MODEL.format(inside).replace('a.dae', mesh))
        file = world_file.read(str(tmp_path / 'm.sdf'), {})
        assert file.findings == ()
        look, = file.trees[0].model.links[0].looks
        image = draw(Visual(0, look.shape, look.pose.matrix(), *look[2:]), pose=looking_down(4.0))
        scale = 160 / np.tan(np.radians(30)) / 4        # pixels for a meter
        return [image[round(120 - scale * x), round(160 - scale * y)].tolist() for x, y in places]
    return colors


def test_a_mesh_without_an_image_has_the_texture_of_the_script(seen):
    left, right = seen(SCRIPT.format('Sign/Whole'), (-0.5, 0), (0.5, 0))
    assert left == pytest.approx([0, 0, 255], abs=2) and right == pytest.approx([255, 0, 0], abs=2)


def test_pixels_are_lit_between_corners_whose_normals_differ_much(tmp_path):
    """The normals are opposite, so those between them have one of the two directions."""
    (tmp_path / 'b.obj').write_text(
        'v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvn 0 -1 0\nvn 0 1 0\n'
        'f 1//1 2//1 3//2\nf 1//1 3//2 4//2\n')
    image = draw(Visual(0, Shape(MESH, (1, 1, 1), str(tmp_path / 'b.obj')), np.eye(4), Material(
        (1.0, 1.0, 1.0, 1.0))), pose=looking_down(4.0), sun=(0.0, 1.0, 0.0))
    assert image[120, [130, 150, 170, 190], 0] == pytest.approx([255, 255, 178, 178], abs=2)


def test_the_scale_of_a_texture_is_about_its_middle(seen):
    places = [(x, 0) for x in (-0.75, -0.25, 0.25, 0.75)]
    colors = [color.index(max(color)) for color in seen(SCRIPT.format('Sign/Half'), *places)]
    assert colors == [0, 2, 0, 2]


def test_transparency_counts_for_the_material_of_a_mesh(seen):
    # the background is 128 64 191
    assert seen('<transparency>0.5</transparency>', (0, 0))[0] == pytest.approx(
        [223, 207, 239], abs=3)      # of a white one, 0.75 is left
    assert seen('<transparency>1</transparency>', (0, 0)) == [[128, 64, 191]]


@pytest.mark.parametrize('how, behind', [
    ('alpha_rejection greater 128', True), ('scene_blend alpha_blend', True),
    ('alpha_rejection always_pass', False)])
def test_what_is_cut_out_of_a_texture_shows_what_is_behind(seen, tmp_path, how, behind):
    image = np.zeros((16, 16, 4), np.uint8)
    image[:, :8] = 255, 0, 0, 255
    Image.fromarray(image).save(str(tmp_path / 'materials' / 'textures' / 'leaf.png'))
    (tmp_path / 'materials' / 'scripts' / 'leaf.material').write_text(
        'material Leaf { technique { pass { %s texture_unit { texture leaf.png } } } }' % how)
    left, right = seen(SCRIPT.format('Leaf'), (-0.5, 0), (0.5, 0))
    assert left == pytest.approx([255, 0, 0], abs=2)
    assert right == ([128, 64, 191] if behind else [0, 0, 0])
