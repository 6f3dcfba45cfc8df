"""Runs pieces by Dask: in processes on this machine, or on the workers of a scheduler."""
import argparse
import contextlib
import logging
import shlex
import tempfile
import time
import warnings
import weakref
from collections import deque
from concurrent.futures import CancelledError
from typing import (Any, ContextManager, Dict, Iterator, List, MutableMapping, Optional, Sequence,
                    Tuple)

import dask
from distributed import (Client, Future, Nanny, Scheduler, SpecCluster, Worker, WorkerPlugin,
                         as_completed)
from distributed.scheduler import KilledWorker
from distributed.security import Security

from img_recog.batch.work import Done, Function, Piece, run_piece
from img_recog.batch.work_folder import versions
from img_recog.errors import UserError, one_line
from img_recog.processes.signals import Interrupts, uninterrupted

_WAIT_S = 10            # for the scheduler, and for its first worker
_IN_FLIGHT = 1000       # pieces that the scheduler knows
_START = 'start some: ./run shell python3 -m distributed.cli.dask_worker {}'
_RECORDS = 100          # of Dask, about pieces that are done; it keeps up to 100,000
# Workers on this machine need no profile of their functions and no ticks: each took 2 % of a core.
_QUIET = {'distributed.worker.profile.interval': '1h', 'distributed.worker.profile.cycle': '1h',
          'distributed.admin.tick.interval': '1s',
          'distributed.admin.system-monitor.interval': '10s',
          'distributed.scheduler.transition-log-length': _RECORDS,
          'distributed.scheduler.events-log-length': _RECORDS}
# A piece that crashes its worker is tried on others. No second one waits there and is blamed, and
# a process that takes 15 s to start again is not given up, until there is none.
_CRASHES = {'distributed.scheduler.worker-saturation': 1.0,
            'distributed.deploy.lost-worker-timeout': '1h'}
_PROBLEMS = (OSError, RuntimeError, TypeError, ValueError, KeyError, AttributeError, ImportError)
_log = logging.getLogger(__name__)


class _FewRecords(WorkerPlugin):
    """Has a worker forget the pieces that are done: no setting of Dask 2022.12 does that."""

    def setup(self, worker: Any) -> None:
        with contextlib.suppress(AttributeError):       # of other versions
            for owner, name in ((worker, 'transfer_outgoing_log'), (worker.state, 'log'),
                                (worker.state, 'stimulus_log')):
                setattr(owner, name, deque(getattr(owner, name), _RECORDS))


class _Silent:
    """Opens no HTTP server: Dask has each scheduler and worker open one."""

    def start_http_server(self, *args: Any, **options: Any) -> None:
        pass


class _Scheduler(_Silent, Scheduler):       # type: ignore[misc]
    pass


class _Worker(_Silent, Worker):             # type: ignore[misc]
    pass


class _Client(Client):
    """One whose end is silent, if it has found no scheduler."""

    def __del__(self) -> None:
        with contextlib.suppress(Exception):
            super().__del__()


def connected(options: argparse.Namespace, interrupts: Interrupts) -> ContextManager[Client]:
    """Return a `with` that has workers; raise UserError if there is no such cluster."""
    # what the user can do something about is said in one line
    for name in [*logging.root.manager.loggerDict, 'asyncio']:
        if name.partition('.')[0] in ('distributed', 'tornado', 'asyncio'):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    return (_cluster(options.scheduler) if options.scheduler
            else _local(options.jobs, interrupts))


@contextlib.contextmanager
def _local(jobs: int, interrupts: Interrupts) -> Iterator[Client]:
    with contextlib.ExitStack() as stack:
        # Ctrl-C goes to this process alone, which then ends the others
        with interrupts.deferred(), uninterrupted():
            dask.config.set({**_QUIET, **_CRASHES})
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            # Whoever else is on this machine reaches the loopback, and Dask would run his code
            security = Security.temporary()
            common = {'host': '127.0.0.1', 'protocol': 'tls://', 'security': security}
            worker = {'cls': Nanny, 'options': {
                **common, 'worker_class': _Worker, 'nthreads': 1, 'memory_limit': 0,
                'silence_logs': logging.CRITICAL + 1, 'local_directory': folder}}
            cluster = stack.enter_context(SpecCluster(
                scheduler={'cls': _Scheduler, 'options': common}, worker=worker,
                workers={number: worker for number in range(jobs)},
                security=security, silence_logs=logging.CRITICAL + 1))
            client = stack.enter_context(Client(cluster, set_as_default=False))
            client.register_worker_plugin(_FewRecords())
        yield client


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
        found: Any = client.get_versions(packages=['bokeh'])
        if found['scheduler']['packages'].get('bokeh'):
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
        found = {'the scheduler': client.run_on_scheduler(versions),
                 **client.run(versions)}
    except _PROBLEMS as error:
        raise UserError('--scheduler {}: it cannot run img_recog: {}'.format(
            address, one_line(error)), _START.format(shlex.quote(address)))
    for name, theirs in found.items():
        for package, version in versions().items():
            if theirs.get(package) != version:
                raise UserError('--scheduler {}: {} has {} {}, and here is {}'.format(
                    address, name, package, theirs.get(package), version),
                    'install the same versions')


def completed(client: Client, function: Function, pieces: Sequence[Piece],
              options: argparse.Namespace) -> Iterator[Done]:
    """Run pieces, in any order; raise UserError if the cluster ends."""
    # contents of files on workers: Dask forgets one that no piece holds
    copies: MutableMapping[str, Future] = weakref.WeakValueDictionary()
    workers = client.scheduler_info()['workers'].values()
    # a file is in the memory of a worker meanwhile
    window = 2 * sum(worker['nthreads'] for worker in workers) if options.copy else _IN_FLIGHT
    remaining = list(reversed(pieces))
    running: Dict[Future, Tuple[Piece, List[Future]]] = {}
    completed = as_completed([], loop=client.loop)

    def copy(path: str) -> Future:
        found = copies.get(path)
        if found is None:
            with open(path, 'rb') as file:
                found = copies[path] = client.scatter(file.read(), hash=False)
        return found

    def submit() -> None:
        while remaining and len(running) < window:
            piece = remaining.pop()
            sent = [copy(path) for path in piece.files] if options.copy else []
            future = client.submit(run_piece, function, piece.files, sent, piece.arguments,
                                   pure=False)
            running[future] = piece, sent
            completed.add(future)

    submit()
    for future in completed:
        piece, sent = running.pop(future)
        done = _done(piece, future)
        if done is not None:
            yield done
        elif client.status != 'running':
            raise UserError('the scheduler {} is gone'.format(options.scheduler),
                            'start it again, and go on with --resume')
        else:
            remaining.append(piece)
            for path in piece.files:
                copies.pop(path, None)
        submit()


def _done(piece: Piece, future: Any) -> Optional[Done]:
    """Return what a piece gave.

    None if a worker was killed, and with it the file that it alone had. The result may have been
    there, too, and cannot be made again without the file.
    """
    try:
        return Done(piece, *future.result())
    except CancelledError:
        return None
    except KilledWorker:
        return Done(piece, None, 'each worker that ran it has crashed or was killed: a library '
                    'cannot read its files, or it needs more memory than there is', True)
    except Exception as error:      # of Dask: an argument that cannot be sent
        return Done(piece, None, '{}: {}'.format(type(error).__name__, one_line(error)))
