"""doctor.py as a user runs it: beside the demo, without ROS, and in Japanese."""
import os
import subprocess
import sys

from img_recog_helpers.pages import ROOT

SCRIPT = os.path.join(ROOT, 'scripts', 'doctor.py')


def run(command, env):
    done = subprocess.run([*command], env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False, timeout=120)
    return done.returncode, done.stdout.decode()


def test_nothing_is_wrong_with_a_running_demo(ros):
    launched = ros.demo('camera:=synthetic', 'web:=false')
    launched.wait_output('the robot is at the start')
    launched.wait_output('blue=')
    code, output = run(['rosrun', 'img_recog', 'doctor.py'], dict(ros.env, LC_ALL='C.UTF-8'))
    # what the simulator takes under its own name, and nobody uses here, is no note either
    assert code == 0 and 'problem: ' not in output and '/gazebo/' not in output, output


def test_without_ros_and_without_libraries_it_says_so():
    # -S: without the packages of the system
    code, output = run([sys.executable, '-I', '-S', SCRIPT, '--machine'],
                       {'PATH': '/usr/bin:/bin', 'LANG': 'ja_JP.UTF-8', 'HOME': '/root'})
    assert code == 1 and '問題: {} に次のライブラリがありません: '.format(sys.executable) in output
    assert 'Traceback' not in output
