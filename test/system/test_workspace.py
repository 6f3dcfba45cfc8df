"""The package in an ordinary catkin workspace: devel space and install space."""
import os
import pathlib
import shutil
import subprocess

from img_recog_helpers.browser import status_of
from img_recog_helpers.pages import ROOT
from img_recog_helpers.processes import SMALL_CAMERA

# environment variables of a shell in which no setup.bash was sourced
FOREIGN = ('CMAKE_PREFIX_PATH', 'PYTHONPATH', 'ROS_PACKAGE_PATH', 'PKG_CONFIG_PATH',
           'LD_LIBRARY_PATH', 'CATKIN_TEST_RESULTS_DIR')


def bash(script, env):
    done = subprocess.run(['bash', '-e', '-c', script], env=env, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, check=False)
    assert done.returncode == 0, done.stdout.decode()
    return done.stdout.decode()


def modules(package):
    return {path.relative_to(package) for path in package.rglob('*.py')}


def test_both_spaces_have_the_package_and_the_install_space_runs_the_demo(ros, tmp_path):
    workspace = tmp_path / 'catkin_ws'
    (workspace / 'src').mkdir(parents=True)
    env = {name: value for name, value in ros.env.items() if name not in FOREIGN}
    env['PATH'] = '/usr/sbin:/usr/bin:/sbin:/bin'
    noetic = '/opt/ros/noetic/setup.bash'
    before = 'source {}; '.format(noetic) if os.path.exists(noetic) else ''
    # the package of the article, and what doc/install.md says to do with it
    bash('{}cd {}/src && catkin_create_pkg img_recog rospy std_msgs; cd .. && catkin_make'.format(
        before, workspace), env)
    (workspace / 'src' / 'img_recog').rename(tmp_path / 'img_recog_of_the_article')
    for name in 'build', 'devel':
        shutil.rmtree(str(workspace / name))
    (workspace / 'src' / 'img_recog').symlink_to(ROOT)
    bash('{}cd {} && catkin_make install'.format(before, workspace),
         env)
    scripts = [name for name in os.listdir(os.path.join(ROOT, 'scripts')) if name.endswith('.py')]
    assert sorted(os.listdir(str(workspace / 'install' / 'lib' / 'img_recog'))) == sorted(scripts)
    installed, = (workspace / 'install' / 'lib').glob('python3*/*-packages/img_recog')
    assert modules(installed) == modules(pathlib.Path(ROOT, 'src', 'img_recog'))
    for space in ('devel', 'install'):
        setup = '{}source {}/{}/setup.bash; '.format(before, workspace, space)
        found = bash(setup + 'rospack find img_recog', env).strip()
        assert found == str(workspace / {'devel': 'src', 'install': 'install/share'}[space]
                            / 'img_recog')
        # as in the article, which goes on with roscd
        assert bash(setup + 'roscd img_recog; pwd', env).strip() == found
        # of the programs, it starts fastest
        assert 'usage: new_package.py' in bash(
            setup + 'rosrun img_recog new_package.py --help', env)
    demo = ros.start('bash', '-c', setup + 'exec roslaunch -p {} img_recog demo.launch {}'.format(
        ros.port, ' '.join(SMALL_CAMERA)), env=env)
    demo.wait_output('the robot drives forward')
    origin, token = demo.wait_output(r'the page: (\S+)/\?token=(\S+)').groups()
    cookie = 'img_recog_{}={}'.format(origin.rpartition(':')[2], token)
    assert status_of(origin + '/static/live.js', Cookie=cookie)[0] == 200
    assert demo.interrupt() == 0
    assert 'Traceback' not in demo.output, demo.output


GREETER = {
    'package.xml': '<package format="2"><name>greeter</name><version>1.0.0</version>'
                   '<description>-</description>'
                   '<maintainer email="nobody@example.com">nobody</maintainer><license>-</license>'
                   '<buildtool_depend>catkin</buildtool_depend></package>',
    'CMakeLists.txt': """cmake_minimum_required(VERSION 3.5)
project(greeter)
find_package(catkin REQUIRED COMPONENTS genpy message_generation)
add_message_files(FILES Greeting.msg)
generate_messages(LANGS genpy)
catkin_package()
catkin_install_python(PROGRAMS greet DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
""",
    'greet.launch': """<launch>
  <arg name="robot" value="$(find xacro)/xacro --inorder '$(find greeter)/greeter.xacro'"/>
  <param name="robot_description" command="$(arg robot)"/>
</launch>""",
    'greeter.xacro': """<robot name="greeter" xmlns:xacro="http://ros.org/wiki/xacro">
  <xacro:include filename="$(find greeter)/links.xacro"/>
  <xacro:part part_name="hand"/>
</robot>""",
    'links.xacro': """<robot xmlns:xacro="http://ros.org/wiki/xacro">
  <xacro:macro name="part" params="part_name"><link name="${part_name}_link"/></xacro:macro>
</robot>""",
    'msg/Greeting.msg': 'string text\n',
    'greet': '''#!/usr/bin/env python3
from greeter.msg import Greeting
print(Greeting(text="hello from a program").text)
'''}
IN_A_SHELL = "(roscd img_recog; pwd)\n"
ASKED = """rosrun greeter greet
python3 -c 'from greeter.msg import Greeting; print(Greeting(text="hello from Python").text)'
rospack find img_recog
rosrun img_recog new_package.py --help
xacro "$(rospack find greeter)/greeter.xacro"
echo "CMAKE_PREFIX_PATH=$CMAKE_PREFIX_PATH LD_LIBRARY_PATH=$LD_LIBRARY_PATH"
"""


def test_a_workspace_that_was_sourced_before_run_is_kept(tmp_path):
    workspace = tmp_path / 'greeter_ws'
    for name, text in GREETER.items():
        path = workspace / 'src' / 'greeter' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    env = {'HOME': str(tmp_path), 'PATH': '/usr/sbin:/usr/bin:/sbin:/bin'}
    noetic = '/opt/ros/noetic/setup.bash'
    before = 'source {}; '.format(noetic) if os.path.exists(noetic) else ''
    bash('{}cd {} && catkin_make'.format(before, workspace), env)
    # what many ~/.bashrc do: it undoes what was sourced before
    other = tmp_path / 'other_ws'
    bash('{}mkdir -p {}/src && cd {} && catkin_make'.format(before, other, other), env)
    (tmp_path / '.bashrc').write_text('source {}/devel/setup.bash\n'.format(other))
    sourced = 'source {}/devel/setup.bash; cd {}; '.format(workspace, ROOT)
    for shell in ('./run shell bash -e {}', './run shell <{}'):
        # with a program, the shell of ./run shell is not the one that was sourced
        (tmp_path / 'asked').write_text(ASKED + IN_A_SHELL * ('<' in shell))
        output = bash(sourced + shell.format(tmp_path / 'asked'), env)
        for line in ('hello from a program', 'hello from Python', ROOT):
            assert '\n{}\n'.format(line) in '\n' + output, output
        assert output.count('\n{}\n'.format(ROOT)) == 1 + ('<' in shell), output
        assert 'usage: new_package.py' in output, output
        assert '<link name="hand_link"/>' in output, output
        assert 'CMAKE_PREFIX_PATH={0}/devel:{1}/devel'.format(ROOT, workspace) in output, output
        assert '{}/devel/lib'.format(workspace) in output.rpartition('LD_LIBRARY_PATH=')[2], output


def test_a_workspace_on_top_of_this_one_finds_xacro_as_on_noetic(tmp_path):
    """Descriptions such as turtlebot3_description want it from catkin, their launch files too."""
    package = tmp_path / 'robot_ws' / 'src' / 'greeter'
    for name in ('package.xml', 'greet.launch', 'greeter.xacro', 'links.xacro'):
        package.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(GREETER[name].replace(
            '</buildtool_depend>', '</buildtool_depend><depend>xacro</depend>'))
    (package / 'CMakeLists.txt').write_text("""cmake_minimum_required(VERSION 3.5)
project(greeter)
find_package(catkin REQUIRED COMPONENTS xacro)
catkin_package(CATKIN_DEPENDS xacro)
""")
    env = {'HOME': str(tmp_path), 'PATH': '/usr/sbin:/usr/bin:/sbin:/bin'}
    bash('source {}/devel/setup.bash; cd {} && catkin_make'.format(ROOT, tmp_path / 'robot_ws'),
         env)
    for command in ('roslaunch --dump-params greeter greet.launch',
                    'xacro $(rospack find greeter)/greeter.xacro'):
        output = bash('source {}/robot_ws/devel/setup.bash; {}'.format(tmp_path, command), env)
        assert '<link name="hand_link"/>' in output.replace('\\', ''), output
