"""The package in an ordinary catkin workspace: devel space and install space."""
import os
import pathlib
import subprocess

from img_recog_testing.browser import status_of
from img_recog_testing.pages import ROOT

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


def test_devel_and_install_space_run_the_demo(ros, tmp_path):
    workspace = tmp_path / 'catkin_ws'
    (workspace / 'src').mkdir(parents=True)
    (workspace / 'src' / 'img_recog').symlink_to(ROOT)
    env = {name: value for name, value in ros.env.items() if name not in FOREIGN}
    env['PATH'] = '/usr/sbin:/usr/bin:/sbin:/bin'
    noetic = '/opt/ros/noetic/setup.bash'
    before = 'source {}; '.format(noetic) if os.path.exists(noetic) else ''
    bash('{}cd {} && catkin_make install'.format(before, workspace),
         env)
    assert sorted(os.listdir(str(workspace / 'install' / 'lib' / 'img_recog'))) == [
        'check_robot.py', 'check_world.py', 'color_img_recog.py', 'film.py', 'graph.py',
        'new_package.py', 'optional_window.py', 'plot.py', 'pybullet_sim.py', 'replay.py',
        'respawn.py', 'robot_description.py', 'robots.py', 'teleop_key.py', 'tune_colors.py',
        'usb_cam_node.py', 'web.py']
    installed, = (workspace / 'install' / 'lib').glob('python3*/*-packages/img_recog')
    assert modules(installed) == modules(pathlib.Path(ROOT, 'src', 'img_recog'))
    for space in ('devel', 'install'):
        setup = '{}source {}/{}/setup.bash; '.format(before, workspace, space)
        found = bash(setup + 'rospack find img_recog', env).strip()
        assert found == str(workspace / {'devel': 'src', 'install': 'install/share'}[space]
                            / 'img_recog')
        demo = ros.start('bash', '-c', setup + 'exec roslaunch -p {} img_recog demo.launch '
                         'camera:=synthetic'.format(ros.port), env=env)
        demo.wait_output('the robot drives forward')
        origin, token = demo.wait_output(r'the page: (\S+)/\?token=(\S+)').groups()
        cookie = 'img_recog_{}={}'.format(origin.rpartition(':')[2], token)
        assert status_of(origin + '/static/live.js', Cookie=cookie)[0] == 200
        assert demo.interrupt() == 0
        assert 'Traceback' not in demo.output, demo.output
