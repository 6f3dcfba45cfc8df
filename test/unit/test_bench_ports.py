"""Each master of the benchmark gets a port that no other program can get."""
import contextlib
import socket
import sys

import pytest

from img_recog_helpers.pages import ROOT


@pytest.fixture
def ros_processes(monkeypatch):
    """The module of the benchmark, which starts nothing."""
    monkeypatch.syspath_prepend(ROOT + '/bench')
    import ros_processes
    yield ros_processes
    del sys.modules['ros_processes']


def test_no_other_program_gets_the_port_of_a_master_before_it_listens(ros_processes, monkeypatch):
    commands = []
    monkeypatch.setattr(ros_processes.Master, 'start',
                        lambda self, *command: commands.append(command) or self)
    monkeypatch.setattr(ros_processes.Master, 'pid', 1, raising=False)
    with contextlib.closing(socket.socket()) as other, socket.socket() as master:
        it = ros_processes.Master()
        port = int(commands[0][-1])
        with pytest.raises(OSError, match='in use'):
            other.bind(('127.0.0.1', port))
        # as rosmaster does
        master.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        master.bind(('', port))
        master.listen()
        it.__exit__()
