"""Runs pieces by Dask: in processes on this machine, or on the workers of a scheduler."""
import contextlib
import importlib.util
import logging
import shlex
import signal
import tempfile
import time
import warnings
from collections import deque
from typing import Any, ContextManager, Dict, Iterator, List, Sequence

import dask
from distributed import Client, Future, LocalCluster, WorkerPlugin, as_completed
from distributed.scheduler import KilledWorker

from img_recog.batch import code_version
from img_recog.batch.options import Options
from img_recog.batch.work import Done, Function, Piece, run_piece
from img_recog.errors import UserError, one_line
from img_recog.signals import Interrupts

_WAIT_S = 10            # for the scheduler, and for its first worker
_IN_FLIGHT = 1000       # pieces that the scheduler knows
_SAME = ('python', 'dask', 'distributed')       # versions that have to be equal
_START = 'start some: ./run shell python3 -m distributed.cli.dask_worker {}'
_RECORDS = 100          # of Dask, about pieces that are done; it keeps up to 100,000
# Workers on this machine need no profile of their functions and no ticks: each took 2 % of a core.
_QUIET = {'distributed.worker.profile.interval': '1h', 'distributed.worker.profile.cycle': '1h',
          'distributed.admin.tick.interval': '1s',
          'distributed.admin.system-monitor.interval': '10s',
          'distributed.scheduler.transition-log-length': _RECORDS,
          'distributed.scheduler.events-log-length': _RECORDS}
_PROBLEMS = (OSError, RuntimeError, TypeError, ValueError, KeyError, AttributeError, ImportError)
_log = logging.getLogger(__name__)


class _FewRecords(WorkerPlugin):
    """Has a worker forget the pieces that are done: no setting of Dask 2022.12 does that."""

    def setup(self, worker: Any) -> None:
        with contextlib.suppress(AttributeError):       # of other versions
            for owner, name in ((worker, 'transfer_outgoing_log'), (worker.state, 'log'),
                                (worker.state, 'stimulus_log')):
                setattr(owner, name, deque(getattr(owner, name), _RECORDS))


class _Client(Client):
    """One whose end is silent, if it has found no scheduler."""

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            super().__del__()


def connected(options: Options, interrupts: Interrupts) -> ContextManager[Client]:
    """Return a `with` that has workers; raise UserError if there is no such cluster."""
    # what the user can do something about is said in one line
    for name in [*logging.root.manager.loggerDict, 'asyncio']:
        if name.partition('.')[0] in ('distributed', 'tornado', 'asyncio'):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return (_cluster(options.scheduler) if options.scheduler
            else _local(options.jobs, interrupts))


@contextlib.contextmanager
def _local(jobs: int, interrupts: Interrupts) -> Iterator[Client]:
    has_page = importlib.util.find_spec('bokeh') is not None
    with contextlib.ExitStack() as stack:
        with _starting_workers(interrupts):
            dask.config.set(_QUIET)
            cluster = stack.enter_context(LocalCluster(
                n_workers=jobs, threads_per_worker=1, processes=True, host='127.0.0.1',
                dashboard_address='127.0.0.1:0', memory_limit=0,
                silence_logs=logging.CRITICAL + 1,
                local_directory=stack.enter_context(tempfile.TemporaryDirectory())))
            client = stack.enter_context(Client(cluster, set_as_default=False))
            client.register_worker_plugin(_FewRecords())
        if has_page:
            _log.warning('progress: %s', cluster.dashboard_link)
        yield client


@contextlib.contextmanager
def _starting_workers(interrupts: Interrupts) -> Iterator[None]:
    """Have Ctrl-C go to this process alone, which then ends the others."""
    with interrupts.deferred():
        handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, handler)


def add_workers(client: Client, jobs: int, interrupts: Interrupts) -> None:
    """Have so many processes on this machine."""
    if len(client.scheduler_info()['workers']) < jobs:
        with _starting_workers(interrupts):
            client.cluster.scale(jobs)
            client.wait_for_workers(jobs)


@contextlib.contextmanager
def _cluster(address: str) -> Iterator[Client]:
    try:
        with warnings.catch_warnings():     # of other versions: `_check` says it in one line
            warnings.simplefilter('ignore')
            client = _Client(address, timeout=_WAIT_S, set_as_default=False)
    except _PROBLEMS as error:
        raise UserError('--scheduler {}: no scheduler of Dask answers: {}'.format(
            address, one_line(error)), 'start one: dask-scheduler')
    with contextlib.closing(client):
        _check(client, address)
        versions: Any = client.get_versions(packages=['bokeh'])
        if versions['scheduler']['packages'].get('bokeh'):
            _log.warning('progress: %s', client.dashboard_link)
        yield client


def _check(client: Client, address: str) -> None:
    """Raise UserError unless there are workers, and all run the versions that run here."""
    deadline = time.monotonic() + _WAIT_S
    while not client.scheduler_info()['workers']:
        if time.monotonic() > deadline:
            raise UserError('--scheduler {}: it has no workers'.format(address),
                            _START.format(shlex.quote(address)))
        time.sleep(0.1)
    try:
        versions: Any = client.get_versions()
        here = versions['client']['packages']
        of_others = {'the scheduler': versions['scheduler'], **versions['workers']}
        for name, other in of_others.items():
            for package in _SAME:
                theirs, ours = other['packages'].get(package), here.get(package)
                if theirs != ours:
                    raise UserError('--scheduler {}: {} has {} {}, and here is {}'.format(
                        address, name, package, theirs, ours), 'install the same versions')
        digests = client.run(code_version.digest)
    except _PROBLEMS as error:
        raise UserError('--scheduler {}: its workers cannot run img_recog: {}'.format(
            address, one_line(error)), _START.format(address))
    for name, digest in digests.items():
        if digest != code_version.digest():
            raise UserError('--scheduler {}: the img_recog of {} is not the one that is here'
                            .format(address, name), 'install the same version')


class _Copies:
    """Sends the files of pieces to the workers, once for each file and time that it is needed."""

    def __init__(self, client: Client):
        self._client = client
        self._futures: Dict[str, Future] = {}
        self._users: Dict[str, int] = {}

    def of(self, piece: Piece) -> List[Future]:
        for path in piece.files:
            if path not in self._futures:
                with open(path, 'rb') as file:
                    self._futures[path] = self._client.scatter(file.read(), hash=False)
            self._users[path] = self._users.get(path, 0) + 1
        return [self._futures[path] for path in piece.files]

    def release(self, piece: Piece, is_lost: bool) -> None:
        """Forget files that no other piece needs; if they are lost, they are sent again."""
        for path in piece.files:
            self._users[path] -= 1
            if not self._users[path] or is_lost:
                self._futures.pop(path, None)


def completed(client: Client, function: Function, pieces: Sequence[Piece],
              options: Options) -> Iterator[Done]:
    """Run pieces, in any order; raise UserError if the cluster ends."""
    copies = _Copies(client) if options.copy else None
    workers = client.scheduler_info()['workers'].values()
    # a file is in the memory of a worker meanwhile
    window = 2 * sum(worker['nthreads'] for worker in workers) if copies else _IN_FLIGHT
    remaining = list(reversed(pieces))
    running: Dict[Future, Piece] = {}
    completed = as_completed([], loop=client.loop)

    def submit() -> None:
        while remaining and len(running) < window:
            piece = remaining.pop()
            future = client.submit(run_piece, function, piece.files,
                                   copies.of(piece) if copies else (), piece.arguments,
                                   pure=False)
            running[future] = piece
            completed.add(future)

    submit()
    for future in completed:
        piece = running.pop(future)
        is_lost = future.cancelled()
        if copies:
            copies.release(piece, is_lost)
        if not is_lost:
            yield _done(piece, future)
        elif client.status != 'running':
            raise UserError('the scheduler {} is gone'.format(options.scheduler),
                            'start it again, and go on with --resume')
        else:           # a worker was killed, and the file with it that it alone had
            remaining.append(piece)
        submit()


def _done(piece: Piece, future: Any) -> Done:
    try:
        return Done(piece, *future.result())
    except KilledWorker:
        return Done(piece, b'', 'each worker that ran it has crashed or was killed: a library '
                    'cannot read its files, or it needs more memory than there is')
    except Exception as error:      # of Dask: an argument that cannot be sent
        return Done(piece, b'', '{}: {}'.format(type(error).__name__, one_line(error)))
