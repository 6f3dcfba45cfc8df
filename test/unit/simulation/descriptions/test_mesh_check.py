"""Mesh files that are damaged are refused before PyBullet reads them."""
import struct

import pytest

from img_recog.simulation.bodies import loading
from img_recog.simulation.descriptions import mesh_check
from img_recog.simulation.settings import SimulationError

OBJ = b'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/3\nf -4 -1 -2\n'
ASCII = (b'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n'
         b'endloop\nendfacet\nendsolid a\n')
BINARY = bytes(80) + struct.pack('<I', 1) + struct.pack('<12f', 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,
                                                        0) + bytes(2)
DAE = b'<COLLADA><asset/><library_geometries/></COLLADA>'
ROBOT = ('<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
         'ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision><geometry><mesh filename="{}"/>'
         '</geometry></collision></link></robot>')


def refusal(path):
    with pytest.raises(SimulationError) as error:
        mesh_check.check(str(path))
    text = str(error.value)
    assert text.startswith('cannot read the mesh {}: '.format(path)) and '\n' not in text
    return text


@pytest.mark.parametrize('name, content', [
    ('a.obj', OBJ), ('A.STL', BINARY), ('a.dae', DAE),
    ('a.stl', b'solid' + BINARY[5:]), ('a.obj', OBJ.replace(b'f ', b' f\t')),
    ('a.obj', b'f 1 2 3\n' + OBJ)])
def test_complete_files(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    mesh_check.check(str(tmp_path / name))


@pytest.mark.parametrize('name, content, words', [
    ('a.obj', OBJ[:32], 'it has no face'), ('a.obj', b'', 'it has no face'),
    ('a.obj', OBJ[:-11].replace(b'v 0 0 1\n', b''), 'a face refers to vertex 4 of 3'),
    ('a.obj', OBJ.replace(b'f 1 3', b'f 0 3'), 'a face refers to vertex 0, the first is 1'),
    ('a.obj', OBJ.replace(b'f -4', b'f -5'), 'a face refers to vertex -5 of 4'),
    ('a.obj', OBJ.replace(b'f 1 3', b'f 1 x'), 'invalid literal'),
    ('a.stl', ASCII, 'it is an ASCII STL, and PyBullet reads binary ones'),
    ('a.stl', BINARY[:-1], 'it has 133 bytes, expected 134 for 1 triangles'),
    ('a.stl', BINARY[:50], 'it has 50 bytes, expected 84'), ('a.stl', b'', 'it has 0 bytes'),
    ('a.obj', OBJ.replace(b'v 1 0 0', b'v 1 nan 0'), 'vertex 2 does not have 3 finite coord'),
    ('a.obj', OBJ.replace(b'v 1 0 0', b'v 1 0 1e39'), 'vertex 2 does not have 3 finite coord'),
    ('a.obj', OBJ.replace(b'v 1 0 0', b'v 1 0'), 'vertex 2 does not have 3 finite coord'),
    ('a.stl', BINARY[:96] + b'\0\0\x80\x7f' + BINARY[100:], 'of a vertex is not a finite number'),
    ('a.dae', DAE[:-3], 'unclosed token'), ('a.dae', b'', 'no element found'),
    ('a.dae', b'<!DOCTYPE a [<!ENTITY b "c">]>' + DAE, 'it has the entity b')])
def test_damaged_files(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    text = refusal(tmp_path / name)
    assert words in text and text.endswith('; give a complete DAE, OBJ or binary STL file')


def test_files_that_are_missing_or_of_ten_million_triangles(tmp_path):
    assert 'No such file' in refusal(tmp_path / 'none.stl')
    with open(str(tmp_path / 'a.stl'), 'wb') as file:
        file.truncate(84 + 50 * 10000000)
    assert refusal(tmp_path / 'a.stl').endswith(
        'it has 500000084 bytes, more than 268435456; give one with fewer triangles')


def test_a_damaged_mesh_is_not_given_to_pybullet(tmp_path, capfd):
    (tmp_path / 'a.stl').write_bytes(BINARY[:-1])
    client = loading.connect()
    capfd.readouterr()
    with pytest.raises(SimulationError, match='cannot read the mesh'):
        loading.load_urdf(ROBOT.format(tmp_path / 'a.stl'), client)
    assert capfd.readouterr() == ('', '')
