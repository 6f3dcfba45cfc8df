"""Fixtures for several tests of batch/."""
import argparse
import contextlib
import signal

import psutil
import pytest

from img_recog.processes import signals
from img_recog.processes.signals import Interrupts


def listening():
    """Return the addresses and ports at which this process and its children listen."""
    me = psutil.Process()
    return {tuple(each.laddr) for process in (me, *me.children(recursive=True))
            for each in process.connections('tcp') if each.status == psutil.CONN_LISTEN}


@pytest.fixture(scope='package')
def workers():
    """Two processes of Dask for all tests here, which take seconds to start.

    The client, and where they listen.
    """
    from img_recog.batch import cluster
    handlers = {signum: signal.getsignal(signum) for signum in signals.ENDING}
    before = listening()
    with cluster.connected(argparse.Namespace(scheduler='', jobs=2), Interrupts()) as client:
        yield client, listening() - before
    for signum, handler in handlers.items():
        signal.signal(signum, handler)


@pytest.fixture
def two_processes(workers, monkeypatch):
    """Have an Engine run pieces in `workers`, if it has more than one job."""
    @contextlib.contextmanager
    def connected(options, interrupts):
        yield workers[0]
    monkeypatch.setattr('img_recog.batch.cluster.connected', connected)
    return workers
