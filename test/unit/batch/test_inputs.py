"""What results depend on: each file that is read for a world and a robot, and its absence."""
import os
import re

import pytest
from PIL import Image

from img_recog.batch import sweep_run, work_folder
from img_recog_helpers import sdf
from img_recog_helpers.robots import FOLDER

BURGER = os.path.join(FOLDER, 'turtlebot3_burger.urdf')
TRIANGLE = 'v 0 0 0\nv 1 0 {}\nv 0 1 1\nvt 0 0\nf 1/1 2/1 3/1\n'
MESH = '<geometry><mesh><uri>{}</uri></mesh></geometry>'
SCRIPT = ('<material><script><uri>paint.material</uri><name>Paint</name></script></material>')
MODEL = ('<model name="m"><static>1</static><link name="l"><visual name="v">' + MESH
         + '{}</visual><collision name="c">' + MESH + '</collision></link></model>')
ROBOT = ('<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
         '<xacro:include filename="base.xacro"/><xacro:base/></robot>')
BASE = ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="base">'
        '<link name="base"><inertial><mass value="2"/>'
        '<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<visual><geometry><mesh filename="file://part.obj"/></geometry></visual></link>'
        '</xacro:macro></robot>')


def write_image(path, color):
    Image.new('RGB', (2, 2), color).save(str(path))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A world with a mesh, an included model and materials, and a robot in xacro."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))
    monkeypatch.setenv('GAZEBO_MODEL_PATH', '{0}/first:{0}/models'.format(tmp_path))
    monkeypatch.setenv('PWD', str(tmp_path))
    monkeypatch.chdir(tmp_path)
    for name, texture in (('wall', 'mtllib wall.mtl\nusemtl a\n'), ('painted', ''), ('part', '')):
        (tmp_path / (name + '.obj')).write_text(texture + TRIANGLE.format(1))
    (tmp_path / 'wall.mtl').write_text('newmtl a\nmap_Kd wall.png\n')
    write_image(tmp_path / 'wall.png', 'red')
    (tmp_path / 'paint.material').write_text(
        'material Paint { technique { pass { diffuse 1 0 0 } } }')
    (tmp_path / 'models' / 'crate').mkdir(parents=True)
    (tmp_path / 'models' / 'crate' / 'model.sdf').write_text(
        '<sdf version="1.6">{}</sdf>'.format(sdf.CRATE.format('0 0 1 0 0 0')))
    (tmp_path / 'w.world').write_text(sdf.sdf(
        MODEL.format('wall.obj', '', 'wall.obj'),
        MODEL.format('painted.obj', SCRIPT, 'painted.obj').replace('"m"', '"n"'),
        '<include><uri>model://crate</uri></include>'))
    (tmp_path / 'r.urdf.xacro').write_text(ROBOT)
    (tmp_path / 'base.xacro').write_text(BASE)
    return tmp_path


def digest():
    sweep_run.inputs.cache_clear()       # as another program
    found, _ = sweep_run.inputs('w.world', 'r.urdf.xacro')
    assert re.fullmatch('[0-9a-f]{64}', found)      # else it says why nothing was read
    return found


def test_all_files_that_are_read_are_named(folder):
    digest()
    found = sweep_run.inputs('w.world', 'r.urdf.xacro')[1]
    names = {os.path.basename(path) for path in found}
    assert names == {'r.urdf.xacro', 'base.xacro', 'model.sdf', 'wall.obj', 'wall.mtl', 'wall.png',
                     'painted.obj', 'paint.material', 'part.obj'}
    assert found == {path: work_folder.identity(path) for path in found}


def test_files_of_a_robot_that_cannot_be_read_are_named_too(folder):
    (folder / 'base.xacro').write_text('<robot>')
    sweep_run.inputs.cache_clear()
    problem, found = sweep_run.inputs('w.world', 'r.urdf.xacro')
    assert 'base.xacro' in problem
    assert {os.path.basename(path) for path in found} == {'r.urdf.xacro', 'base.xacro'}


def write(folder, name, old, new):
    path = folder / name
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize('name, old, new', [
    ('w.world', '>', '><!-- -->'),         # alone makes no difference
    ('w.world', 'name="m"', 'name="k"'), ('wall.obj', '1 0 1', '1 0 2'),
    ('wall.mtl', 'newmtl', 'Kd 1 0 0\nnewmtl'), ('part.obj', '1 0 1', '1 0 2'),
    ('paint.material', '1 0 0', '0 0 1'), ('models/crate/model.sdf', '<mass>2', '<mass>3'),
    ('base.xacro', 'link name="base"', 'link name="root"')])
def test_each_file_that_is_read_makes_a_difference(folder, name, old, new):
    before = digest()
    write(folder, name, old, new)
    assert (digest() == before) is ('<!--' in new)
    write(folder, name, new, old)
    assert digest() == before


def test_the_content_of_a_texture_and_not_when_it_was_written(folder):
    before = digest()
    os.utime('wall.png', (0, 0))
    assert digest() == before
    write_image(folder / 'wall.png', 'lime')
    assert digest() != before


@pytest.mark.parametrize('name', ['wall.png', 'wall.mtl', 'paint.material', 'part.obj'])
def test_a_file_that_is_missing_and_appears(folder, name):
    before = digest()
    os.rename(name, 'away')
    missing = digest()
    os.rename('away', name)
    assert missing != before == digest()


def test_a_model_that_is_found_earlier(folder):
    before = digest()
    os.makedirs('first/crate')
    (folder / 'first' / 'crate' / 'model.sdf').write_text(
        '<sdf version="1.6">{}</sdf>'.format(sdf.SHELF))
    assert digest() != before


def test_robots_and_worlds_of_this_package(folder):
    digests = {sweep_run.inputs(world, BURGER)[0] for world in ('empty', 'color_posts')}
    assert len(digests | {digest()}) == 3


def test_python_and_the_libraries_are_among_the_versions():
    assert {'img_recog', 'Python', 'OpenCV', 'numpy', 'pybullet', 'moderngl'} <= set(
        work_folder.versions())


def test_a_large_file_is_known_by_its_ends_and_its_time(tmp_path):
    path = tmp_path / 'film'
    content = bytearray(3 << 20)
    path.write_bytes(content)
    os.utime(str(path), (1, 1))
    before = work_folder.identity(str(path))
    os.utime(str(path), (2, 2))
    assert work_folder.identity(str(path)) != before


def test_a_large_file_that_is_changed_in_the_middle_and_keeps_its_time(tmp_path):
    path = tmp_path / 'film'
    path.write_bytes(bytes(5 << 20))
    os.utime(str(path), (1, 1))
    before = work_folder.identity(str(path))
    with path.open('r+b') as file:
        file.seek(5 << 19)
        file.write(b'x')
    os.utime(str(path), (1, 1))
    assert work_folder.identity(str(path)) != before
