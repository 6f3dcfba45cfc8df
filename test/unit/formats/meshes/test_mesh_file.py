"""Mesh files are read by trimesh; what is damaged or too large is an error of one line."""
import io
import re
import struct

import numpy as np
import pytest
from PIL import Image

from img_recog.formats import materials
from img_recog.formats.meshes import collada, mesh_file
from img_recog.formats.meshes.mesh_file import MeshError
from img_recog.formats.materials import TextureError
from img_recog_helpers import bombs

COLLADA = '''<COLLADA version="1.4.1" xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset><unit name="inch" meter="0.0254"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse>
<color>0.2 0.4 0.6 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="a" count="9">0 0 0 100 0 0 0 0 100</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/>
<p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>'''
OBJ = ('v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no first\nf 1 3 2\nf 1 2 4\no second\nf 1 4 3\n'
       'f 2 3 4\n')
CORNERS = (0, 0, 0), (1, 0, 0), (0, 1, 0)
ASCII = 'solid a\nfacet normal 0 0 1\nouter loop\n{}endloop\nendfacet\nendsolid a\n'.format(
    ''.join('vertex {} {} {}\n'.format(*corner) for corner in CORNERS))
BINARY = b''.join((bytes(80), struct.pack('<I', 1),
                   struct.pack('<12f', 0, 0, 1, *sum(CORNERS, ())), bytes(2)))


def put(folder, name, content):
    """Return the path of a new mesh file."""
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(folder / name)


def refusal(path):
    """Return why a mesh file is refused, to draw it and for PyBullet."""
    reasons = set()
    for use in (mesh_file.read, lambda path: mesh_file.write(path, '/nowhere')):
        with pytest.raises(MeshError) as error:
            use(path)
        reasons.add(str(error.value))
    reason, = reasons
    assert reason.startswith('cannot read the mesh {}: '.format(path)) and '\n' not in reason
    assert reason.endswith('; give a DAE, OBJ or STL file that is complete')
    return reason


def test_collada_in_its_unit_and_without_its_up_axis(tmp_path):
    part, = mesh_file.read(put(tmp_path, 'a.dae', COLLADA))
    assert part.positions.reshape(-1, 3).max(axis=0) == pytest.approx([2.54, 0, 2.54])
    assert part.material.color == pytest.approx((0.2, 0.4, 0.6, 1.0), abs=0.005)
    assert part.has_material
    assert np.abs(part.normals[0, 0]) == pytest.approx([0, 1, 0])


TEXTURED = ('mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n'
            'f 1/1 2/2 3/3\n')


def textured(folder, image):
    """Return the first triangles of an OBJ that names the texture `image`."""
    (folder / 'meshes').mkdir(exist_ok=True)
    (folder / 'meshes' / 'a.mtl').write_text('newmtl m\nKd 0.2 0.4 0.6\nmap_Kd {}\n'.format(
        image))
    (folder / 'meshes' / 'a.obj').write_text(TEXTURED)
    part, = mesh_file.read(str(folder / 'meshes' / 'a.obj'))
    assert part.material.color == (0.2, 0.4, 0.6, 1.0)
    assert part.has_material and part.problem == ''
    assert part.uvs[0].tolist() == [[0, 0], [1, 0], [0, 1]]
    return part


def encoded(suffix):
    noise = np.random.RandomState(0).randint(0, 255, (64, 64, 3)).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(noise).save(file, suffix)
    return file.getvalue()


@pytest.mark.parametrize('content, words', [
    (None, ': No such file or directory; give a PNG or JPEG file'),
    (bombs.png(), '20000x20000 pixels are more than 134217728'),
    *((data[:int(share * len(data))], '') for data in map(encoded, ('png', 'jpeg'))
      for share in (0.0, 0.02, 0.5, 0.95))])
def test_a_texture_that_cannot_be_read_is_named(tmp_path, content, words):
    path = tmp_path / 'meshes' / 'a.png'
    if content is not None:
        path.parent.mkdir()
        path.write_bytes(content)
    part = textured(tmp_path, 'a.png')
    with pytest.raises(TextureError) as error:
        materials.read_texture(part.material.texture)
    line = str(error.value)
    assert line.startswith('cannot read the texture {}: '.format(path))
    assert words in line and '\n' not in line


def test_pybullet_gets_the_texture_of_an_obj(tmp_path):
    (tmp_path / 'meshes').mkdir()
    Image.new('RGB', (2, 2), (10, 20, 30)).save(str(tmp_path / 'meshes' / 'a.png'))
    textured(tmp_path, 'a.png')
    path = mesh_file.write(str(tmp_path / 'meshes' / 'a.obj'), str(tmp_path), materials=True)
    part, = mesh_file.read(path)
    assert materials.read_texture(part.material.texture)[0, 0].tolist() == [10, 20, 30]
    assert part.uvs[0].tolist() == [[0, 0], [1, 0], [0, 1]]
    assert part.material.color == pytest.approx((0.2, 0.4, 0.6, 1), abs=1e-6)


def test_pybullet_gets_the_color_of_an_obj_whose_texture_cannot_be_read(tmp_path):
    textured(tmp_path, 'none.png')
    path = mesh_file.write(str(tmp_path / 'meshes' / 'a.obj'), str(tmp_path), materials=True)
    part, = mesh_file.read(path)
    assert part.material.texture == ''
    assert part.material.color == pytest.approx((0.2, 0.4, 0.6, 1), abs=1e-6)
    (tmp_path / 'plain').mkdir()
    path = mesh_file.write(str(tmp_path / 'meshes' / 'a.obj'), str(tmp_path / 'plain'))
    part, = mesh_file.read(path)
    assert path.endswith('.obj') and not part.has_material


def test_pybullet_gets_each_material_of_an_obj(tmp_path):
    mtl = put(tmp_path, 'a.mtl', 'newmtl m\nKd 0.2 0.4 0.6\nnewmtl n\nKd 1 0 0.8\n')
    path = put(tmp_path, 'a.obj', TEXTURED.replace('usemtl m', 'f 3 2 1\nusemtl m')
               + 'usemtl n\nf 1/1 3/3 2/2\n')
    assert mesh_file.material_files(path) == [mtl]
    (tmp_path / 'written').mkdir()
    parts = mesh_file.read(mesh_file.write(path, str(tmp_path / 'written'), materials=True))
    colors = {tuple(np.round(part.material.color, 6)) for part in parts}
    assert len(parts) == 3 and {(0.2, 0.4, 0.6, 1), (1, 0, 0.8, 1)} <= colors


def test_the_normals_of_an_obj_count_where_they_are_no_zeros(tmp_path):
    part, = mesh_file.read(put(
        tmp_path, 'a.obj', 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.6 0 0.8\nvn 0 0 0\nvn 0 0.6 0.8\n'
        'f 1//1 2//2 3//3\n'))
    assert part.normals == pytest.approx(np.array([[[0.6, 0, 0.8], [0, 0, 1], [0, 0.6, 0.8]]]))


@pytest.mark.parametrize('name, content, top', [
    ('a.obj', OBJ.replace('v 1 0 0', 'v 999999999 0 0'), 999999999),
    ('a.dae', COLLADA.replace(' 0 100<', ' 0 1e10<'), 2.54e8),
    ('a.dae', COLLADA.replace('meter="0.0254"', ''), 100),
    ('a.dae', COLLADA.replace('meter="0.0254"', 'meter="2"'), 200)])
def test_large_coordinates_and_units(tmp_path, name, content, top):
    parts = mesh_file.read(put(tmp_path, name, content))
    assert max(part.positions.max() for part in parts) == pytest.approx(top, rel=1e-9)


@pytest.mark.parametrize('name, content, count', [
    ('a.obj', OBJ, 4), ('a.obj', OBJ.replace('f 2 3 4', ' f\t-3/1 -2/2 -1/3'), 4),
    ('a.obj', OBJ.replace('o first', '').replace('o second', ''), 4),
    ('A.STL', BINARY, 1), ('a.stl', b'solid' + BINARY[5:], 1), ('a.stl', ASCII, 1),
    ('a.dae', COLLADA, 1), ('a.dae', COLLADA.replace('<triangles', '<!-- b --><triangles'), 1),
    ('a.dae', COLLADA.replace('<instance_geometry', '<translate>1 2 3</translate>'
                              '<instance_geometry'), 1),
    ('a.dae', COLLADA.replace('<node>', '<node><node/>'), 1)])
def test_pybullet_gets_the_same_triangles(tmp_path, name, content, count):
    path = put(tmp_path, name, content)
    drawn = np.concatenate([part.positions for part in mesh_file.read(path)])
    (tmp_path / 'written').mkdir()
    written = np.concatenate([part.positions for part in mesh_file.read(
        mesh_file.write(path, str(tmp_path / 'written')))])
    assert written.shape == (count, 3, 3)
    order = [np.lexsort(each.reshape(-1, 9).round(5).T) for each in (drawn, written)]
    assert written[order[1]] == pytest.approx(drawn[order[0]], rel=1e-6, abs=1e-7)


@pytest.mark.parametrize('name, content, words', [
    ('a.obj', '', ''), ('a.obj', OBJ[:32], ''), ('a.obj', 'v 0 0 0\nf 1 2 3\n', 'out of bounds'),
    ('a.obj', OBJ.replace('f 1 3', 'f 0 3'), 'a face refers to vertex 0 of 4, the first is 1'),
    ('a.obj', OBJ.replace('f 1 3', 'f -5 3'), 'a face refers to vertex -5 of 4'),
    ('a.obj', OBJ.replace('v 1 0 0', 'v nan 0 0'), 'it has a coordinate of more than 1e+09'),
    ('a.obj', OBJ.replace('v 1 0 0', 'v 1e9 0 0'), 'it has a coordinate of more than 1e+09'),
    ('a.obj', OBJ.replace('v 1 0 0', 'v inf 0 0'), 'it has a coordinate of more than 1e+09'),
    ('a.obj', OBJ.replace('v 1 0 0', 'v -1e10 0 0'), 'it has a coordinate of more than 1e+09'),
    ('a.stl', b'', ''), ('a.stl', BINARY[:50], ''), ('a.stl', BINARY[:-1], ''),
    ('a.stl', 'solid a\n', ''), ('a.stl', ASCII[:70], 'it has 2 corners in 1 facets'),
    ('a.stl', BINARY[:96] + b'\0\0\x80\x7f' + BINARY[100:], 'a coordinate of more than 1e+09'),
    ('a.dae', '', ''), ('a.dae', '<COLLADA/>', ''),
    ('a.xyz', '1 2 3', "its name ends with '.xyz', expected .dae, .obj, .stl")])
def test_a_mesh_that_cannot_be_read_is_named(tmp_path, name, content, words):
    assert words in refusal(put(tmp_path, name, content))


@pytest.mark.parametrize('old, new, words', [
    ('0 1 2<', '0 1 3<', 'it has 0 triangles, allowed are 1 to 3000000'),
    ('0 1 2<', '0 1 x<', ''), ('0 1 2<', '<', ''),
    (' 0 100<', ' 1e12 100<', 'it has a coordinate of more than 1e+09'),
    ('0.0254', '0', 'its unit has the length 0'), ('0.0254', 'nan', 'its unit has the length nan'),
    ('url="#scene"', 'url="#none"', 'it has no visual scene'),
    ('0.0254', '-1', 'its unit has the length -1'),
    ('source="#p"', 'source="#q"', ''), ('offset="0"', 'offset="2"', ''),
    ('<scene>.*</scene>', '', ''),
    ('^', '<!DOCTYPE a [<!ENTITY b "c">]>', 'it has entities, or is not UTF-8'),
    ('^', '\0', 'it has entities, or is not UTF-8')])
def test_a_damaged_collada_is_refused(tmp_path, old, new, words):
    content = re.sub(old, new, COLLADA, flags=re.DOTALL)
    assert content != COLLADA and words in refusal(put(tmp_path, 'a.dae', content))


def test_every_truncated_collada_is_refused(tmp_path):
    for length in range(0, len(COLLADA), 7):
        refusal(put(tmp_path, 'a.dae', COLLADA[:length]))


def test_a_mesh_of_too_many_triangles_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_file, 'MAX_TRIANGLES', 3)
    assert 'it has 4 triangles, allowed are 1 to 3;' in refusal(put(tmp_path, 'a.obj', OBJ))
    monkeypatch.setattr(mesh_file, 'MAX_TRIANGLES', 4)
    assert sum(len(part.positions) for part in mesh_file.read(str(tmp_path / 'a.obj'))) == 4
    path = put(tmp_path, 'b.stl', b'')
    with open(path, 'wb') as file:       # of 10 million triangles
        file.truncate(84 + 50 * 10000000)
    assert 'it has 500000084 bytes, more than 268435456;' in refusal(path)
    assert 'No such file' in refusal(str(tmp_path / 'none.stl'))


@pytest.mark.parametrize('depth, shapes', [(3, 8), (40, None)])
def test_nodes_that_refer_to_nodes_may_not_do_so_without_end(tmp_path, monkeypatch, depth,
                                                             shapes):
    monkeypatch.setattr(collada, '_MAX_NODES', 2000)
    geometry = COLLADA[COLLADA.index('<instance_geometry'):COLLADA.index('</node>')]
    nodes = ['<node id="n0">{}</node>'.format(geometry)] + [
        '<node id="n{}">{}</node>'.format(number, '<instance_node url="#n{}"/>'.format(
            number - 1) * 2) for number in range(1, depth + 1)]
    path = put(tmp_path, 'a.dae', COLLADA.replace(
        geometry, '<instance_node url="#n{}"/>'.format(depth)).replace(
        '<library_visual', '<library_nodes>{}</library_nodes><library_visual'.format(
            ''.join(nodes)), 1))
    if shapes is not None:
        part, = mesh_file.read(path)
        assert len(part.positions) == shapes
    else:
        with pytest.raises(MeshError, match='it has more than 2000 nodes'):
            mesh_file.read(path)
