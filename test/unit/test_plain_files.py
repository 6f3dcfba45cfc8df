"""A pipe or a device that a file names as a file is refused: its reader could wait for ever."""
import os
import signal

import pytest

from img_recog import files
from img_recog.camera import calibration
from img_recog.checks import world_check
from img_recog.errors import UserError
from img_recog.formats import heightmaps, materials
from img_recog.formats.meshes import mesh_file
from img_recog.loading import robot_file
from img_recog.model import HEIGHTMAP, Shape
from img_recog.nodes.robots import robot_list
from img_recog.recognition import parameter_file
from img_recog.recognition.fitting import sample_file
from img_recog_helpers.sdf import sdf

TRIANGLE = 'v 0 0 0\nv 1 0 0\nv 0 1 0\n{}\nf 1 2 3\n'
_DEADLINE_S = 60


@pytest.fixture(autouse=True)
def deadline():
    """End what waits for a pipe."""
    def fail(*_):
        raise TimeoutError('waited for a pipe')
    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(_DEADLINE_S)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def pipe(folder, name):
    path = str(folder / name)
    os.mkfifo(path)
    return path


def written(folder, name, text):
    path = folder / name
    path.write_text(text)
    return str(path)


def test_only_files_are_opened(tmp_path):
    given = written(tmp_path, 'file', 'text')
    os.symlink(given, str(tmp_path / 'link'))
    for path in (given, str(tmp_path / 'link')):
        with open(path, opener=files.plain) as file:
            assert file.read() == 'text'
    for path in (pipe(tmp_path, 'pipe'), '/dev/null', '/dev/zero'):
        with pytest.raises(UserError, match=path + ' is a pipe or device, not a'):
            open(path, opener=files.plain)
    with pytest.raises(IsADirectoryError):
        open(str(tmp_path), opener=files.plain)


def obj(folder, line, other='usemtl a'):
    return written(folder, 'a.obj', line + '\n' + TRIANGLE.format(other))


def heightmap(folder):
    return heightmaps.read(Shape(HEIGHTMAP, (1.0, 1.0, 1.0, 1), pipe(folder, 'p')))


def robots(folder, key):
    listed = robot_list.read_robots(
        written(folder, 'robots.yaml', '[{{name: a, {}: {}}}]'.format(key, pipe(folder, 'p'))),
        {}, lambda uri: None)
    reason, = listed.problems.values()
    raise UserError(reason)


def xacro(folder):
    return robot_file.read(written(
        folder, 'a.xacro', '<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro">'
        '<xacro:include filename="{}"/></robot>'.format(pipe(folder, 'p'))))


def mask(folder):
    pipe(folder, 'p.png')
    return sample_file.read(written(
        folder, 'samples.yaml', 'samples: [{color: red, mask: p.png}]'))


@pytest.mark.parametrize('read, words', [
    (lambda folder: mesh_file.read(pipe(folder, 'p.stl')),
     'cannot read the mesh {0}.stl: {0}.stl is a pipe or device, not a file; give a DAE'),
    (lambda folder: mesh_file.read(obj(folder, 'mtllib ' + pipe(folder, 'p'))),
     'cannot read the mesh {1}/a.obj: {0} is a pipe or device, not a file; give a DAE'),
    (lambda folder: mesh_file.read(obj(folder, 'mtllib /dev/stdin')),
     'cannot read the mesh {1}/a.obj: /dev/stdin is a pipe or device, not a file; give a DAE'),
    (lambda folder: materials.read_texture(pipe(folder, 'p')),
     'cannot read the texture {0}: {0} is a pipe or device, not a file; give a PNG'),
    (heightmap, 'heightmap {0}: {0} is a pipe or device, not a file; give a PNG'),
    (mask, '{1}/samples.yaml: entry 1: cannot read the mask {0}.png: {0}.png is a pipe or device'),
    (lambda folder: calibration.load(pipe(folder, 'p')),
     'cannot read calibration {0}: {0} is a pipe or device, not a file'),
    (lambda folder: robots(folder, 'urdf'), 'urdf: got {0!r}, allowed is the path or'),
    (lambda folder: robots(folder, 'colors'), 'colors: got {0!r}, allowed is the path'),
    (xacro, 'xacro cannot expand {1}/a.xacro: {0} is a pipe or device, not a file')])
def test_what_a_file_names_is_refused(tmp_path, monkeypatch, read, words):
    monkeypatch.setattr(robot_file, '_ros_command', lambda: None)
    if read == xacro:
        pytest.importorskip('xacro.substitution_args')
    stdin = os.dup(0)
    ends = os.pipe()
    os.dup2(ends[0], 0)
    try:
        with pytest.raises(UserError) as error:
            read(tmp_path)
    finally:
        os.dup2(stdin, 0)
        for each in (stdin, *ends):
            os.close(each)
    assert str(error.value).startswith(words.format(str(tmp_path / 'p'), tmp_path))


def test_a_texture_that_is_a_pipe_is_named(tmp_path):
    library = written(tmp_path, 'a.mtl', 'newmtl a\nmap_Kd {}\n'.format(pipe(tmp_path, 'p')))
    part, = mesh_file.read(obj(tmp_path, 'mtllib ' + os.path.basename(library)))
    with pytest.raises(materials.TextureError, match='is a pipe or device, not a file'):
        materials.read_texture(part.material.texture)
    mesh_file.write(str(tmp_path / 'a.obj'), str(tmp_path), materials=True)


@pytest.mark.parametrize('shape, words', [
    ('mtllib', 'cannot read the mesh {1}/a.obj: {0} is a pipe or device, not a file'),
    ('mesh', 'loaded without: mesh {}'),
    ('include', 'loaded without: file://{}'), ('script', 'drawn in another color: material a')])
def test_a_world_names_what_is_left_out(tmp_path, shape, words):
    named = pipe(tmp_path, 'p.stl')
    uri = obj(tmp_path, 'mtllib p.stl') if shape == 'mtllib' else named
    parts = {'include': '<include><uri>file://{}</uri></include>'.format(named),
             'script': '<model name="m"><static>1</static><link name="l"><visual name="v">'
             '<geometry><box><size>1 1 1</size></box></geometry><material><script><uri>{}</uri>'
             '<name>a</name></script></material></visual></link></model>'.format(named)}
    report = world_check.check(written(tmp_path, 'w.world', sdf(parts.get(
        shape, '<model name="m"><static>1</static><link name="l"><visual name="v"><geometry>'
        '<mesh><uri>file://{}</uri></mesh></geometry></visual></link></model>'.format(uri)))))
    lines = [*(row.what for row in report.rows), *report.warnings]
    assert any(words.format(named, tmp_path) in line for line in lines), lines


def test_pipes_that_users_name_are_read(tmp_path):
    path = pipe(tmp_path, 'colors')
    child = os.fork()
    if not child:
        with open(path, 'w') as file:
            file.write('colors: [blue, red]\nblue_hue_min: 50\n')
        os._exit(0)
    assert parameter_file.read(path).blue_hue_min == 50
    os.waitpid(child, 0)
