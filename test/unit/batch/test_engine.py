"""Pieces of work: their outcomes, in any number of processes, interrupted, killed and resumed."""
import argparse
import contextlib
import os
import pickle
import signal
import socket
from typing import Any, NamedTuple

import dask
import pytest
from distributed import Client, LocalCluster

from img_recog.batch import cluster, work_folder
from img_recog.batch.engine import Engine
from img_recog.batch.work import Piece
from img_recog.processes.signals import Interrupts
from img_recog_helpers import batch_work
from img_recog_helpers.refusals import refusal

WAIT_S = 10


class Outcome(NamedTuple):
    """The result of a piece, or why there is none."""

    key: str
    value: Any = None
    problem: str = ''


def started(tmp_path, **options):
    """Return an Engine in a folder; options: those that are not the defaults, but one job."""
    return Engine(argparse.Namespace(**{
        'jobs': 1, 'scheduler': '', 'copy': False, 'resume': False, **options}),
        Interrupts(), str(tmp_path / 'x'))


@pytest.fixture
def run(tmp_path, handlers_as_before):
    """A function that runs pieces; it returns the list of outcomes."""
    def run(function, pieces, **options):
        with started(tmp_path, **options) as engine:
            found = list(engine.run(function, pieces))
            return [Outcome(piece.key, *(value for other, value in found if other is piece),
                            problem=engine.problems.get(piece.key, '')) for piece in pieces]
    return run


def numbers(*arguments, count=6):
    return [Piece('run {}'.format(number), (number, *arguments)) for number in range(count)]


def test_outcomes_are_in_the_order_of_the_pieces_and_nothing_is_left(run, tmp_path):
    assert run(batch_work.square, numbers()) == [
        Outcome('run {}'.format(number), number * number) for number in range(6)]
    assert os.listdir(str(tmp_path)) == []


def test_problems_of_a_piece_are_its_outcome_and_nothing_is_left(run, tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('abc')
    pieces = [Piece(str(factor), (factor,), (str(path),)) for factor in (2, 0, None)]
    fine, refused, failed = run(batch_work.count_bytes, pieces)
    assert fine.value == [6] and fine.problem == ''
    assert refused == Outcome('0', problem='the factor is 0; give another')
    assert failed.value is None and failed.problem.startswith('TypeError: ')
    assert os.listdir(str(tmp_path)) == ['a.txt']
    assert run(batch_work.count_bytes, pieces, resume=True)[1] == refused


def test_a_library_that_crashes_takes_nothing_with_it_and_its_file_is_named(
        run, tmp_path, capfd, caplog):
    paths = [tmp_path / '{}.flv'.format(number) for number in range(8)]
    for path in paths:
        path.touch()
    pieces = [Piece(path.name, (number, str(tmp_path / 'killed')), (str(path),))
              for number, path in enumerate(paths)]
    # as on a busy machine, where a process takes longer to start again than Dask waits
    with dask.config.set({'distributed.deploy.lost-worker-timeout': '1ms',
                          'distributed.scheduler.allowed-failures': 1}):
        found = run(batch_work.crashes, pieces, jobs=2)
    assert [each.value for each in found] == [0, 1, 2, None, 4, 5, 6, 7]
    assert (tmp_path / 'killed').exists()
    assert found[3].problem == (
        'each worker that ran it has crashed or was killed: a library cannot read its files, or '
        'it needs more memory than there is')
    assert '<crashes {}>'.format(paths[3]) in capfd.readouterr().err
    # on a machine with more memory it may succeed
    assert '7 of 8 pieces are done and kept in {}; go on'.format(
        tmp_path / 'x.work') in caplog.text
    assert len(kept(tmp_path)) == 7


def test_what_a_killed_worker_alone_had_is_copied_again(run, tmp_path):
    path = tmp_path / 'a.txt'
    path.touch()
    pieces = [Piece(str(number), (number, str(tmp_path / 'killed')), (str(path),))
              for number in range(5, 9)]
    with LocalCluster(n_workers=1, threads_per_worker=1, host='127.0.0.1', dashboard_address=None,
                      worker_dashboard_address=None) as cluster:
        found = run(batch_work.crashes, pieces, scheduler=cluster.scheduler_address, copy=True)
    assert (tmp_path / 'killed').exists()
    assert [each.value for each in found] == [5, 6, 7, 8]


def test_an_interrupted_run_goes_on_without_doing_anything_twice(run, tmp_path, caplog):
    pieces = numbers(str(tmp_path))
    with pytest.raises(KeyboardInterrupt):
        run(batch_work.interrupted, pieces)
    assert '3 of 6 pieces are done and kept in {}; go on with --resume'.format(
        tmp_path / 'x.work') in caplog.text
    (tmp_path / 'go').touch()
    assert [each.value for each in run(batch_work.interrupted, pieces, resume=True)] == [
        0, 1, 4, 9, 16, 25]
    assert [(tmp_path / str(number)).read_text() for number in range(6)] == ['x'] * 6


def test_without_resume_all_is_done_again(run, tmp_path):
    pieces = numbers(str(tmp_path), count=2)
    with contextlib.suppress(RuntimeError):
        with started(tmp_path) as engine:
            engine.run(batch_work.square, pieces)
            raise RuntimeError
    run(batch_work.square, pieces)
    assert (tmp_path / '0').read_text() == 'xx'


@pytest.fixture
def processes(two_processes, tmp_path):
    """An Engine with two processes, which stay for all tests, and where these listen."""
    with started(tmp_path / 'two', jobs=2) as engine:
        yield engine, two_processes[1]


def test_the_processes_stay_for_more_pieces(processes, tmp_path):
    found = []
    for count in (2, 6):
        folder = tmp_path / str(count)
        folder.mkdir()
        found.append({pid for _, pid in processes[0].run(
            batch_work.process, numbers(str(folder), 2, count=count))})
    assert len(found[0]) == 2 and found[0] == found[1] and os.getpid() not in found[0]


def test_workers_use_freed_memory_again_and_keep_few_records(processes):
    faults, records = ([value for _, value in processes[0].run(function, pieces)]
                       for function, pieces in ((batch_work.page_faults, numbers(100)),
                                                (batch_work.records, numbers(count=90))))
    assert max(faults) < 3000       # 25000 if each of the 100 buffers of 1 MB is mapped anew
    assert max(records) == 100      # 400 of what 45 pieces did


def test_a_file_that_has_changed_is_read_again(run, tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('abc')
    pieces = [Piece('1', (1,), (str(path),)), Piece('0', (0,), (str(path),))]
    assert run(batch_work.count_bytes, pieces)[0].value == [3]
    path.write_text('abcd')
    assert run(batch_work.count_bytes, pieces, resume=True)[0].value == [4]


@pytest.mark.parametrize('jobs', [1, 2])
@pytest.mark.parametrize('is_given', [True, False])
def test_a_file_that_changes_meanwhile_ends_the_run(run, tmp_path, is_given, jobs):
    """is_given: to the function, which else reads it by itself."""
    path = str(tmp_path / 'a.txt')
    (tmp_path / 'a.txt').write_text('abc')
    read = {} if is_given else {path: work_folder.identity(path)}
    pieces = [Piece(str(number), (number,) if is_given else ([path], number),
                    (path,) if is_given else (), read=read) for number in range(6)]
    function = batch_work.changes if is_given else batch_work.changes_by_itself
    line = refusal(run, function, pieces, jobs=jobs)
    assert line.startswith(path + ' has changed since it was read first; go on with --resume')
    if jobs == 1:
        assert len(kept(tmp_path)) == 3


def test_a_file_that_changes_between_two_stages_ends_the_run(tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('abc')
    with started(tmp_path) as engine:
        engine.watch([str(path)])
        path.write_text('abd')
        assert 'a.txt has changed since' in refusal(
            engine.run, batch_work.count_bytes, [Piece('1', (1,), (str(path),))])


def test_two_runs_do_not_have_one_output(run, tmp_path):
    pieces = numbers(str(tmp_path), count=2)
    with started(tmp_path) as engine:
        first = engine.run(batch_work.square, pieces)
        line = refusal(run, batch_work.square, pieces)
        assert line == ('cannot use {}: another program that runs writes its results there; wait '
                        'until it ends, or set --output to another').format(tmp_path / 'x.work')
        assert [value for _, value in first] == [0, 1]
    assert [each.value for each in run(batch_work.square, pieces)] == [0, 1]
    assert sorted(os.listdir(str(tmp_path))) == ['0', '1']


def test_a_ctrl_c_while_processes_start_is_not_lost(run, tmp_path, monkeypatch):
    start = cluster.SpecCluster

    def interrupted(*args, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return start(*args, **options)
    monkeypatch.setattr(cluster, 'SpecCluster', interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(batch_work.square, numbers(str(tmp_path)), jobs=2)
    assert os.listdir(str(tmp_path)) == []


def test_without_pieces_there_is_no_progress(run, capsys, monkeypatch):
    monkeypatch.setattr('sys.stderr.isatty', lambda: True, raising=False)
    run(batch_work.square, [])
    assert capsys.readouterr().err == ''


def test_results_of_other_versions_are_made_again(interrupted, tmp_path, monkeypatch):
    versions = dict(work_folder.versions(), numpy='0')
    monkeypatch.setattr(work_folder, 'versions', lambda: versions)
    assert [each.value for each in interrupted()] == [0, 1, 4, 9, 16, 25]
    assert (tmp_path / '0').read_text() == 'xx'


@pytest.mark.parametrize('address, words', [
    ('tcp://127.0.0.1:1', 'no scheduler of Dask answers'), ('nonsense', 'no scheduler of Dask')])
def test_a_scheduler_that_is_not_there_is_one_line(run, monkeypatch, address, words):
    monkeypatch.setattr('img_recog.batch.cluster._WAIT_S', 0.5)
    assert words in refusal(run, batch_work.square, numbers(), scheduler=address)


def test_a_file_that_cannot_be_read_is_a_problem_of_its_pieces_alone(run, tmp_path):
    (tmp_path / 'a').touch()
    lost, fine = run(batch_work.count_bytes, [Piece(name, (1,), (str(tmp_path / name),))
                                              for name in ('missing', 'a')])
    assert lost.problem == 'FileNotFoundError: No such file or directory' and fine.value == [0]


def test_pieces_of_one_key_are_known_by_their_values(run):
    pieces = [Piece('same', (number,)) for number in (2, 3, 2)]
    assert [each.value for each in run(batch_work.square, pieces)] == [4, 9, 4]


def test_a_problem_names_its_own_file_among_those_of_equal_content(run, processes, tmp_path):
    paths = [str(tmp_path / name) for name in ('a.bag', 'b.bag')]
    for path in paths:
        open(path, 'w').close()
    pieces, engine = [Piece(path, (), (path,)) for path in paths], processes[0]
    engine.run(batch_work.refused, pieces)
    expected = ['cannot read ' + path for path in paths]
    assert [each.problem for each in run(batch_work.refused, pieces)] == expected
    assert [engine.problems[path] for path in paths] == expected


def kept(tmp_path):
    """Return the paths of results."""
    return sorted(tmp_path.glob('x.work/*/*.piece'))


@pytest.fixture
def interrupted(run, tmp_path):
    """A function that resumes a run of which three of six pieces are done."""
    pieces = numbers(str(tmp_path))
    with pytest.raises(KeyboardInterrupt):
        run(batch_work.interrupted, pieces)
    (tmp_path / 'go').touch()
    return lambda: run(batch_work.interrupted, pieces, resume=True)


@pytest.mark.parametrize('damage', [
    lambda content: b'', lambda content: content[:-9], lambda content: b'x' * 99,
    lambda content: content.replace(b'descr', b'DESCR'), lambda content: pickle.dumps(7)])
def test_a_damaged_result_is_made_again(interrupted, tmp_path, damage):
    for path in kept(tmp_path):
        path.write_bytes(damage(path.read_bytes()))
    assert [each.value for each in interrupted()] == [0, 1, 4, 9, 16, 25]
    assert [(tmp_path / str(number)).read_text() for number in range(4)] == ['xx', 'xx', 'xx', 'x']


def test_results_are_of_this_user_alone(interrupted, tmp_path):
    for path in (tmp_path / 'x.work', *(tmp_path / 'x.work').glob('**/*')):
        assert path.stat().st_mode & 0o77 == 0


def open_to_all(path):
    path.chmod(0o777)


def linked(path):
    path.rename(path.with_name('elsewhere'))
    path.symlink_to(path.with_name('elsewhere'))


def given_away(path):
    os.chown(str(path), 65534, 65534)


@pytest.mark.parametrize('change, why', [
    (open_to_all, 'others can write it'), (linked, 'it is a link'),
    (given_away, 'it belongs to another user')])
@pytest.mark.parametrize('which', [0, 1, 2])
def test_what_others_may_have_put_there_is_refused(interrupted, tmp_path, change, why, which):
    if change is given_away and os.geteuid() != 0:
        pytest.skip('only root gives files away')
    path = kept(tmp_path)[0]
    change([path.parent.parent, path.parent, path][which])
    line = refusal(interrupted)
    assert why in line and 'remove it' in line


def test_no_run_uses_a_folder_of_others(run, tmp_path):
    (tmp_path / 'x.work').mkdir()
    (tmp_path / 'x.work').chmod(0o777)
    assert 'others can write it' in refusal(run, batch_work.square, numbers())


def answers(address, port):
    """Return what answers HTTP, then a client of Dask without the key."""
    with socket.create_connection((address, port), WAIT_S) as connection:
        connection.settimeout(WAIT_S)
        connection.sendall(b'GET / HTTP/1.0\r\n\r\n')
        try:
            yield connection.recv(4)
        except ConnectionError:
            yield b''
    with contextlib.suppress(OSError):
        with Client('tcp://{}:{}'.format(address, port), timeout=1, set_as_default=False):
            yield b'a client'


def test_workers_listen_on_the_loopback_alone_and_to_this_user_alone(processes):
    _, found = processes
    assert len(found) >= 5 and {address for address, _ in found} == {'127.0.0.1'}
    for address, port in found:
        assert not [each for each in answers(address, port) if each in (b'HTTP', b'a client')]
