"""What happens at most once in a period of wall time."""
from img_recog.nodes.throttle import Throttle


def test_ready_once_in_a_period(clock):
    throttle = Throttle(5.0, clock)
    assert throttle.ready()
    assert not throttle.ready()
    clock.advance(4.9)
    assert not throttle.ready()
    clock.advance(0.2)
    assert throttle.ready() and not throttle.ready()
