"""new_package.py: the package that it makes is built, and its tests pass, as doc/ci.md says.

What it refuses is in test/unit/test_new_package.py.
"""
import json
import os
import pathlib
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

import pytest
import yaml

from img_recog_testing.pages import ROOT

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


def test_its_tests_pass_in_a_workspace(ros, src):
    assert new_package(ros, 'post_driver', src)[0] == 0
    assert not [path for path in (src / 'post_driver').rglob('*') if path.is_file()
                and 'my_robot' in str(path) + path.read_text()]
    done = ros.start('bash', '-c', 'cd {} && catkin_make && catkin_make run_tests_post_driver && '
                     'catkin_test_results build/test_results'.format(src.parent))
    assert done.wait() == 0, done.output
    results = src.parent / 'build' / 'test_results' / 'post_driver'
    names = [case.get('name') for path in results.glob('*.xml')
             for case in ElementTree.parse(str(path)).iter('testcase')]
    assert sorted(names) == [
        'test_the_robot_drives_to_the_post',
        'test_the_robot_drives_to_the_post_on_the_same_path_each_time',
        'testtest_post_driver']         # that the rostest has run


def test_a_name_that_cannot_be_used(ros, src):
    code, line = new_package(ros, 'gazebo', src)
    assert (code, line) == (1, 'new_package.py: demo.launch has a node gazebo; choose another '
                            'name\n')
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
