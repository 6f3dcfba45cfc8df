"""The arguments of the demo: errors are one line before anything starts; relative paths work."""
import os
import shutil
import subprocess

import pytest

from img_recog_helpers.pages import ROOT, launch_arguments
from img_recog_helpers.waiting import DEADLINE_S, stretch


def checked(*words):
    """Let ./run demo check its arguments; return its exit code and output."""
    done = subprocess.run(['./run', 'demo', *words], cwd=ROOT, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=DEADLINE_S * stretch(),
                          check=False)
    return done.returncode, done.stdout.decode()


SWITCHES = ('gui', 'image_view', 'paused', 'recognition', 'simulator', 'teleop', 'use_sim_time',
            'allow_partial_world', 'vision')
REFUSED = {
    ('camera=synthetic',): 'got camera=synthetic; write camera:=synthetic',
    ('camera:=', 'synthetic'): 'got a space after camera:=; write camera:=synthetic',
    ('camera', ':=synthetic'): 'got a space before :=; write camera:=synthetic',
    ('synthetic',): 'got synthetic; write arguments like camera:=synthetic; ./run demo --help ',
    ('camra:=synthetic',): 'demo.launch has no argument camra; did you mean camera?\n',
    ('xyz:=1',): 'demo.launch has no argument xyz; ./run demo --help lists them\n',
    ('_video_device:=0',): 'demo.launch has no argument _video_device; ./run demo --help lists ',
    ('camera:=/no/such.mp4',): 'camera: got /no/such.mp4, which does not exist; allowed are auto, '
                               'synthetic, robot, none, a URL, and the path of ',
    ('camera:=',): "camera: got '', which does not exist",
    ('camera:=ftp://host/video.mp4',): 'camera: got a URL of ftp://; allowed are http://, ',
    ('camera_info_url:=my.yaml',): 'camera_info_url: got my.yaml, allowed are file:///PATH ',
    ('record:=/no/such/x.bag',): 'record: /no/such is no folder where files can be written; ',
    ("record:=it's.bag",): "record: got it's.bag, allowed is a path without an apostrophe; ",
    ('record:=',): "record: got '', allowed is a path",
    ('-p',): '-p needs a value',
    ('--screen', 'gui:=yes'): 'gui: got yes, allowed is true or false; write gui:=true',
    **{(name + ':=auto',): '{0}: got auto, allowed is true or false; write {0}:=true\n'.format(
        name) for name in SWITCHES},
}


@pytest.mark.parametrize('words', list(REFUSED), ids=' '.join)
def test_refused(words):
    code, output = checked(*words)
    assert code == 1
    assert output.startswith('[run] ' + REFUSED[words]), output
    assert output.count('\n') == 1, output


def test_help_lists_all_arguments_in_groups_with_their_defaults():
    code, output = checked('--help')
    assert code == 0
    lines = output.splitlines()
    assert {'camera', 'simulator', 'more of simulator.launch'} <= set(lines)
    for arg in launch_arguments().values():
        name, default = arg.name, arg.default.replace('$(find img_recog)/', '')
        begin = lines.index('  ' + name if '$(' in default else '  {}:={}'.format(name, default))
        assert ' '.join(output.split('\n', begin + 1)[-1].split()).startswith(
            ' '.join(arg.doc.split())), name


@pytest.mark.parametrize('name', ['old', 'old.bag'])
def test_a_recording_replaces_no_file(tmp_path, name):
    (tmp_path / 'old.bag').write_text('')
    assert checked('record:={}/{}'.format(tmp_path, name)) == (
        1, '[run] record: {}/old.bag exists; give another name, or remove it\n'.format(tmp_path))
    assert checked('--ros-args', 'record:={}/new'.format(tmp_path))[0] == 0
    (tmp_path / 'new.bag.active').write_text('')
    code, output = checked('record:={}/new'.format(tmp_path))
    assert code == 1
    assert output.startswith('[run] record: {}/new.bag.active exists: '.format(tmp_path))


DEFAULTS = [(each.name, each.default) for each in launch_arguments().values()]


@pytest.mark.parametrize('words', [
    [name + ':=False' for name in SWITCHES],
    ('camera:=none', 'world:=empty', 'x_pos:=-1e-3', 'framerate:=29.97', '--screen'),
    ('camera:=rtsp://user:word@host/stream', '-p', '11399', 'gui:=1'),
    ('camera:=urdf', 'real_time_factor:=0'),
    ['{}:={}'.format(name, value) for name, value in DEFAULTS if '$(' not in value]])
def test_accepted(words):
    # with --ros-args, roslaunch lists the arguments and exits
    code, output = checked('--ros-args', *words)
    assert code == 0, output


@pytest.fixture
def folder(tmp_path):
    """The folder of a user with files of all kinds."""
    path = tmp_path / 'mine'
    (path / 'images').mkdir(parents=True)
    cv2 = pytest.importorskip('cv2')
    for name in ('photo.png', 'images/1.png'):
        assert cv2.imwrite(str(path / name), cv2.UMat(48, 64, cv2.CV_8UC3, (9, 9, 9)).get())
    shutil.copy(os.path.join(ROOT, 'config', 'colors.yaml'), str(path / 'my_colors.yaml'))
    shutil.copy(os.path.join(ROOT, 'urdf', 'turtlebot3_burger.urdf'), str(path / 'my.urdf'))
    shutil.copy(os.path.join(ROOT, 'urdf', 'turtlebot3_world.urdf'), str(path / 'my_world.urdf'))
    return path


# each way starts two demos: one with a path in every argument that takes one, one with a folder
RELATIVE = {
    'files': (('camera:=photo.png', 'camera_info_url:=file://my_camera.yaml',
               'world:=my_world.urdf', 'urdf:=my.urdf', 'colors:=my_colors.yaml',
               'teleop:=false', 'gui:=false', 'image_view:=false', 'web:=false'),
              ('camera: .*image {}/photo.png',
               'camera is not calibrated: there is no file {}/my_camera.yaml',
               'simulating 1.0017 kg.* in world .*my_world.urdf', r'blue=\d+, red=\d+')),
    'folder': (('camera:=images', 'simulator:=false', 'recognition:=false', 'teleop:=false'),
               ('camera: .*{}/images',)),
}


@pytest.mark.parametrize('way', ['./run', 'roslaunch'])
@pytest.mark.parametrize('arguments, expected', list(RELATIVE.values()), ids=list(RELATIVE))
def test_relative_paths_start_at_the_working_directory(ros, folder, way, arguments, expected):
    command = {'./run': (os.path.join(ROOT, 'run'), 'demo'),
               'roslaunch': ('roslaunch', 'img_recog', 'demo.launch')}[way]
    demo = ros.start('bash', '-c', 'cd "$0" && exec "$@"', folder, *command, *arguments,
                     # also on a busy machine, the supervisor kills no node that ends by itself
                     env=dict(ros.env, IMG_RECOG_END_SCALE='10'))
    for line in expected:
        demo.wait_output(line.format(folder))
    assert '[FATAL]' not in demo.output and '[ERROR]' not in demo.output, demo.output
    assert demo.interrupt() == 0
