"""A node that lets another one drive."""
import pytest
from std_srvs.srv import TriggerRequest

from img_recog.ros import yielding
from img_recog.ros.yielding import YIELD_S, Yielding


@pytest.fixture
def offered(monkeypatch):
    """The time, and the handlers of the services that are offered."""
    class Offered(dict):
        time_s = 50.0
    services = Offered()
    monkeypatch.setattr(yielding.rospy, 'Service',
                        lambda name, kind, handler: services.update({name: handler}))
    monkeypatch.setattr(yielding.time, 'monotonic', lambda: services.time_s)
    return services


def test_a_call_lasts_for_a_moment_and_another_one_prolongs_it(offered):
    node = Yielding()
    assert not node.is_active()
    assert offered['~yield'](TriggerRequest()).success
    offered.time_s += 0.8 * YIELD_S
    assert node.is_active()
    offered['~yield'](TriggerRequest())
    offered.time_s += 0.8 * YIELD_S
    assert node.is_active()
    offered.time_s += 0.3 * YIELD_S
    assert not node.is_active()


def test_a_node_that_refuses_says_why(offered):
    node = Yielding(lambda: 'it is driven by keys')
    answer = offered['~yield'](TriggerRequest())
    assert (answer.success, answer.message) == (False, 'it is driven by keys')
    assert not node.is_active()
