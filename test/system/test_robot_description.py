"""The demo's argument urdf with a xacro file: the parameter robot_description, or an error."""
import stat

import pytest

PACKAGE = ('<package><name>xacro</name><version>1.14.0</version><description>d</description>'
           '<maintainer email="a@b.c">a</maintainer><license>BSD</license></package>')
# replaces xacro of ROS 1, which Debian does not have, nor the package that stands in for it there
COMMAND = '''#!/bin/sh
grep -q size "$1" || { echo "undefined symbol: size" >&2; exit 2; }
echo '<robot name="expanded"/>'
'''


@pytest.fixture
def dump(ros, tmp_path):
    """A function that returns what roslaunch prints about the parameters for a robot file."""
    package, folder = tmp_path / 'packages' / 'xacro', tmp_path / 'bin'
    package.mkdir(parents=True)
    folder.mkdir()
    (package / 'package.xml').write_text(PACKAGE)
    (folder / 'xacro').write_text(COMMAND)
    (folder / 'xacro').chmod(stat.S_IRWXU)
    env = dict(ros.env, PATH='{}:{}'.format(folder, ros.env['PATH']))
    env['ROS_PACKAGE_PATH'] = '{}:{}'.format(
        tmp_path / 'packages', ros.env['ROS_PACKAGE_PATH'])

    def run(text, arguments=''):
        (tmp_path / 'my robot.urdf.xacro').write_text(text)
        process = ros.start('roslaunch', '--dump-params', 'img_recog', 'demo.launch',
                            'urdf:=my robot.urdf.xacro' + arguments, env=env, cwd=str(tmp_path))
        process.wait()
        return process.output
    return run


@pytest.mark.parametrize('arguments', ['', ' arm=true'])
def test_xacro_file_is_expanded(dump, arguments):
    assert '/robot_description: \'<robot name="expanded"/>' in dump('<robot size="1"/>', arguments)


def test_xacro_file_that_cannot_be_expanded_gives_a_line_with_the_reason(dump):
    lines = dump('<robot/>').splitlines()
    assert ('robot_description.py: error: xacro cannot expand my robot.urdf.xacro: undefined '
            'symbol: size') in lines, lines
    assert not [line for line in lines if line.startswith('/robot_description')]
