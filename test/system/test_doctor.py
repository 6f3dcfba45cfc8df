"""doctor.py without ROS, and in Japanese; test_demo.py runs it beside the demo."""
import os
import subprocess
import sys

from img_recog_helpers.pages import ROOT

SCRIPT = os.path.join(ROOT, 'scripts', 'doctor.py')


def test_without_ros_and_without_libraries_it_says_so():
    # -S: without the packages of the system
    done = subprocess.run([sys.executable, '-I', '-S', SCRIPT, '--machine'], check=False,
                          env={'PATH': '/usr/bin:/bin', 'LANG': 'ja_JP.UTF-8', 'HOME': '/root'},
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=120)
    output = done.stdout.decode()
    assert done.returncode == 1 and '問題: {} に次のライブラリがありません: '.format(sys.executable) in output
    assert 'Traceback' not in output
