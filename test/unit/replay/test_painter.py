"""The process that draws the picture: its result, and what happens when it ends early."""
import os
import pickle
import re
import signal
import subprocess
import sys

import numpy as np
import pytest

from img_recog.errors import UserError
from img_recog.recognition.settings import with_colors
from img_recog.replay.painter import Painter
from img_recog.replay.plot_data import PlotData
from img_recog_testing.waiting import wait_for

DATA = PlotData(with_colors()().colors, np.ones((3, 6)), np.ones((3, 3)), np.ones((2, 3)),
                np.zeros((0, 3)), 1.0, [])


def test_a_killed_process_is_reported():
    with Painter() as painter:
        os.kill(painter.pid, signal.SIGKILL)
        os.waitid(os.P_PID, painter.pid, os.WEXITED | os.WNOWAIT)
        painter.begin('a test', DATA)
        with pytest.raises(UserError, match='cannot be drawn: .* exit code -9; check whether it '
                           'was killed because memory ran out'):
            painter.finish()


def test_it_draws_in_spite_of_interrupts_until_the_end_of_the_with():
    def ignores(signum):
        with open('/proc/{}/status'.format(painter.pid)) as file:
            return int(re.search('SigIgn:\t(.*)', file.read()).group(1), 16) >> signum - 1 & 1

    with Painter() as painter:
        for signum in (signal.SIGINT, signal.SIGHUP):
            wait_for(lambda: ignores(signum), 'a process that has begun')
            os.kill(painter.pid, signum)
        painter.begin('a test', DATA)
        assert painter.finish().startswith(b'\x89PNG')
        assert os.path.exists('/proc/{}'.format(painter.pid))
    assert not os.path.exists('/proc/{}'.format(painter.pid))


# a program that is killed does not come to the end of its with
KILLED = """
import os, pickle, signal, sys
from img_recog.replay.painter import Painter
painter = Painter()
if sys.argv[1:]:
    with open(sys.argv[1], 'rb') as file:
        painter.begin('a test', pickle.load(file))
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize('is_drawing', [False, True])
def test_it_ends_quietly_when_nobody_waits(tmp_path, is_drawing):
    (tmp_path / 'data').write_bytes(pickle.dumps(DATA))
    done = subprocess.run([sys.executable, '-c', KILLED, *[str(tmp_path / 'data')] * is_drawing],
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    # the process has both streams too: they have come to their ends because it has ended
    assert (done.returncode, done.stderr) == (-signal.SIGKILL, b'')
