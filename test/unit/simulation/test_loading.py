"""Physics clients."""
import pybullet
import pytest

from img_recog.simulation import loading
from img_recog.simulation.settings import SimulationError


@pytest.fixture(params=[-1, 0, 7])
def number(request, monkeypatch):
    """The number of the client that PyBullet gives; a negative one means that it has none."""
    monkeypatch.setattr(pybullet, 'connect', lambda mode: request.param)
    monkeypatch.setattr(pybullet, 'setPhysicsEngineParameter', lambda **values: None)
    return request.param


def test_first_client_has_the_number_0_and_a_negative_one_is_an_error(number):
    if number >= 0:
        assert loading.connect() == number
    else:
        with pytest.raises(SimulationError, match='cannot start a physics client'):
            loading.connect()
