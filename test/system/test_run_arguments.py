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


# a path in every argument that takes one; and a folder. What ./run makes of them is a unit test
@pytest.mark.parametrize('arguments, expected', [
    (('camera:=photo.png', 'camera_info_url:=file://my_camera.yaml', 'world:=my_world.urdf',
      'urdf:=my.urdf', 'colors:=my_colors.yaml', 'teleop:=false'),
     ('camera: .*image {}/photo.png',
      'camera is not calibrated: there is no file {}/my_camera.yaml',
      'simulating 1.0017 kg.* in world .*my_world.urdf', r'blue=\d+, red=\d+')),
    (('camera:=images', 'simulator:=false', 'recognition:=false', 'teleop:=false'),
     ('camera: .*{}/images',))], ids=['files', 'folder'])
def test_relative_paths_start_at_the_working_directory(ros, folder, arguments, expected):
    demo = ros.roslaunch('img_recog', 'demo.launch', *arguments, 'web:=false', cwd=str(folder),
                         env=dict(ros.env, PWD=str(folder)))
    for line in expected:
        demo.wait_output(line.format(folder))
    assert '[FATAL]' not in demo.output and '[ERROR]' not in demo.output, demo.output
    assert demo.interrupt() == 0
