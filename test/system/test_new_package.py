"""new_package.py and what it makes; what it refuses is in test/unit/test_new_package.py."""
import json
import os
import pathlib
import shutil
import subprocess

import pytest
import yaml

from img_recog_helpers.pages import ROOT

TEMPLATE = pathlib.Path(ROOT, 'templates', 'my_robot_vision')


@pytest.fixture
def src(tmp_path):
    """The folder src of a workspace."""
    folder = tmp_path / 'ws' / 'src'
    folder.mkdir(parents=True)
    return folder


def new_package(ros, name, folder):
    process = ros.start_node('new_package.py', name, str(folder))
    return process.wait(), process.output


def test_it_has_the_name_everywhere(ros, src):
    """That it is built and its tests pass, lesson 6 holds (test_lessons.py)."""
    assert new_package(ros, 'post_driver', src)[0] == 0
    files = [path for path in (src / 'post_driver').rglob('*') if path.is_file()]
    assert not [path for path in files if 'my_robot' in str(path) + path.read_text()]
    assert len(files) > 10


def test_a_name_that_cannot_be_used(ros, src):
    code, line = new_package(ros, 'gazebo', src)
    assert (code, line) == (
        1, 'new_package.py: error: simulator.launch has a node gazebo; choose another name\n')
    assert not [*src.iterdir()]


def test_ros_does_not_find_the_template(ros, src):
    (src / 'img_recog').symlink_to(ROOT)
    env = dict(ros.env, ROS_PACKAGE_PATH=str(src))
    assert ros.start('rospack', 'find', 'my_robot_vision', env=env).wait() != 0
    order = ros.run('catkin_topological_order', str(src), '--only-names')
    assert order.split() == ['img_recog']
    launch = ros.run('roslaunch', '--files', 'img_recog', 'demo.launch')
    assert 'templates' not in launch
    # rosrun finds programs that are executable
    assert not [path for path in TEMPLATE.rglob('*') if path.is_file()
                and path.stat().st_mode & 0o111]


def test_the_files_for_ci_can_be_read():
    workflow = yaml.safe_load((TEMPLATE / '.github/workflows/ci.yml').read_text())
    gitlab = yaml.safe_load((TEMPLATE / '.gitlab-ci.yml').read_text())
    container = json.loads((TEMPLATE / '.devcontainer' / 'devcontainer.json').read_text())
    assert gitlab['test']['image'] == workflow['jobs']['test']['container'] == 'debian:bookworm'
    dockerfile = (TEMPLATE / '.devcontainer' / container['build']['dockerfile']).read_text()
    assert container['workspaceFolder'] in dockerfile.split()


def test_ci_sh_needs_the_address(src):
    shutil.copy(str(TEMPLATE / 'ci.sh'), str(src))
    done = subprocess.run(['sh', str(src / 'ci.sh')], stderr=subprocess.PIPE, check=False)
    assert done.returncode == 1 and b'write the address of img_recog into this file' in done.stderr
    assert os.listdir(str(src)) == ['ci.sh']
