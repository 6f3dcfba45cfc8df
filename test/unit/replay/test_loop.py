"""Reading ahead of the chain."""
import threading

import pytest

from img_recog.replay.loop import prefetch
from img_recog_helpers.waiting import wait_for


@pytest.mark.parametrize('count', [0, 1, 3, 4, 5, 1000])
def test_prefetch_gives_the_same_items_in_the_same_order(count):
    assert list(prefetch(range(count), 4)) == list(range(count))


def test_prefetched_items_are_made_ahead_in_another_thread_but_not_more_than_depth():
    made, threads = [], set()

    def items():
        for number in range(100):
            threads.add(threading.current_thread())
            made.append(number)
            yield number

    taken = prefetch(items(), 4)
    assert next(taken) == 0
    wait_for(lambda: len(made) == 5, 'the four that follow')
    assert next(taken) == 1
    wait_for(lambda: len(made) == 6, 'one more')
    taken.close()
    assert len(made) == 6
    assert len(threads) == 1 and threading.current_thread() not in threads


def test_an_exception_of_prefetched_items_is_raised_after_the_items_before_it():
    def items():
        yield 1
        yield 2
        raise ValueError('no more')

    taken = prefetch(items(), 8)
    assert [next(taken), next(taken)] == [1, 2]
    with pytest.raises(ValueError, match='no more'):
        next(taken)
