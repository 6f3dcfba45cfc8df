"""Pieces of work: their outcomes, in any number of processes, interrupted, killed and resumed."""
import contextlib
import os

import pytest

from img_recog.batch import engine
from img_recog.batch.engine import Outcome
from img_recog.batch.options import Options
from img_recog.batch.work import Piece
from img_recog.errors import UserError
from img_recog.signals import Interrupts
from img_recog_testing import batch_work


@pytest.fixture
def run(tmp_path, handlers_as_before):
    """A function that runs pieces; it returns the list of outcomes."""
    def run(function, pieces, **options):
        with engine.outcomes(function, pieces, str(tmp_path / 'work'), Options(**options),
                             Interrupts()) as outcomes:
            return list(outcomes)
    return run


def numbers(*arguments, count=6):
    return [Piece('run {}'.format(number), (number, *arguments)) for number in range(count)]


def test_outcomes_are_in_the_order_of_the_pieces_and_nothing_is_left(run, tmp_path):
    assert run(batch_work.square, numbers()) == [
        Outcome('run {}'.format(number), number * number) for number in range(6)]
    assert os.listdir(str(tmp_path)) == []


def test_problems_of_a_piece_are_its_outcome_and_done_again(run, tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('abc')
    pieces = [Piece(str(factor), (factor,), (str(path),)) for factor in (2, 0, None)]
    fine, refused, failed = run(batch_work.count_bytes, pieces)
    assert fine.value == [6] and fine.problem == ''
    assert refused == Outcome('0', problem='the factor is 0; give another')
    assert failed.value is None and failed.problem.startswith('TypeError: ')
    assert (tmp_path / 'work').exists()
    assert run(batch_work.count_bytes, pieces, resume=True)[1] == refused


def test_two_processes_give_what_one_gives_though_a_worker_is_killed(run, tmp_path):
    pieces = numbers(str(tmp_path))
    found = run(batch_work.killed_once, pieces, jobs=2)
    assert (tmp_path / 'killed').exists()
    assert found == run(batch_work.killed_once, pieces, jobs=1)


def test_an_interrupted_run_goes_on_without_doing_anything_twice(run, tmp_path, caplog):
    pieces = numbers(str(tmp_path))
    with pytest.raises(KeyboardInterrupt):
        run(batch_work.interrupted, pieces)
    assert '3 of 6 pieces are done and kept in {}; go on with --resume'.format(
        tmp_path / 'work') in caplog.text
    (tmp_path / 'go').touch()
    assert [each.value for each in run(batch_work.interrupted, pieces, resume=True)] == [
        0, 1, 4, 9, 16, 25]
    assert [(tmp_path / str(number)).read_text() for number in range(6)] == ['x'] * 6


def test_without_resume_all_is_done_again(run, tmp_path):
    pieces = numbers(str(tmp_path), count=2)
    with contextlib.suppress(RuntimeError):
        with engine.outcomes(batch_work.square, pieces, str(tmp_path / 'work'), Options(),
                             Interrupts()):
            raise RuntimeError
    run(batch_work.square, pieces)
    assert (tmp_path / '0').read_text() == 'xx'


def test_a_file_that_has_changed_is_read_again(run, tmp_path):
    path = tmp_path / 'a.txt'
    path.write_text('abc')
    pieces = [Piece('1', (1,), (str(path),)), Piece('0', (0,), (str(path),))]
    assert run(batch_work.count_bytes, pieces)[0].value == [3]
    path.write_text('abcd')
    assert run(batch_work.count_bytes, pieces, resume=True)[0].value == [4]


@pytest.mark.parametrize('address, words', [
    ('tcp://127.0.0.1:1', 'no scheduler of Dask answers'), ('nonsense', 'no scheduler of Dask')])
def test_a_scheduler_that_is_not_there_is_one_line(run, monkeypatch, address, words):
    monkeypatch.setattr('img_recog.batch.cluster._WAIT_S', 0.5)
    with pytest.raises(UserError) as refused:
        run(batch_work.square, numbers(), scheduler=address)
    assert words in str(refused.value) and '\n' not in str(refused.value)


def test_a_file_that_cannot_be_read(run, tmp_path):
    with pytest.raises(UserError, match='cannot read .*: no such file'):
        run(batch_work.count_bytes, [Piece('1', (1,), (str(tmp_path / 'missing'),))])
