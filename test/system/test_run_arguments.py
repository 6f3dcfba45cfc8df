"""Relative paths in the arguments of the demo work."""
import os
import shutil

import pytest

from img_recog_helpers.pages import ROOT


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
