"""The filters that frames are converted with, in a process that forks."""
import subprocess
import sys

# runs in its own process, because an error makes it hang
FORKS_IN_ANOTHER_THREAD = '''
import gc, os, subprocess, sys, threading
import av, numpy
from img_recog.camera.decoder import rgb_array

frame = av.VideoFrame.from_ndarray(numpy.zeros((48, 64, 3), numpy.uint8), format='bgr24')
assert rgb_array(frame).shape == (48, 64, 3)
codes = []


def fork():
    codes.append(subprocess.call(['true'], preexec_fn=gc.collect))


thread = threading.Thread(target=fork)
thread.start()
thread.join()
assert codes == [0] and rgb_array(frame).shape == (48, 64, 3)
'''


def test_a_fork_in_another_thread_does_not_wait_for_the_filters_of_this_one():
    subprocess.run([sys.executable, '-c', FORKS_IN_ANOTHER_THREAD], check=True, timeout=60)
