"""Ctrl-C while a test lets simulated time pass."""
import queue
import random
import signal
import threading
import time
from types import SimpleNamespace

import pytest
from rosgraph_msgs.msg import Clock

from img_recog.testing.running import Running

INTERRUPTS, LONGEST_S = 300, 2e-3


@pytest.fixture
def running():
    """What lets time pass, without a simulator: a call takes 1 ms."""
    made = Running.__new__(Running)
    made._arrived, made._calls, made._responses = (
        threading.Lock(), queue.SimpleQueue(), queue.SimpleQueue())
    made._arrived.acquire()
    made._call_count, made._now_s, made._period_s, made._wall_timeout_s = 0, 0.0, 0.1, 60.0
    made.launch = SimpleNamespace(check=lambda: None)
    made.topics = SimpleNamespace(is_settled=lambda: random.random() < 0.1)

    def step():
        time.sleep(1e-3)
        return SimpleNamespace(success=True)
    made._step = step
    made._caller = threading.Thread(target=made._call, daemon=True)
    made._caller.start()
    yield made
    made._calls.put(-1)


def test_each_interrupt_ends_a_step_and_nothing_stays_locked(running):
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for _ in range(INTERRUPTS):
            with pytest.raises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, random.uniform(1e-5, LONGEST_S))
                while True:
                    running.step(0.1)
            # the thread of the subscriber
            taken = threading.Thread(target=running._take_time, args=(Clock(),), daemon=True)
            taken.start()
            taken.join(10.0)
            assert not taken.is_alive()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    running.step(0.1)
