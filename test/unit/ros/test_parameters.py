"""Parameters that the master cannot send are a fault of the user."""
import xmlrpc.client

import pytest
import rospy

from img_recog.ros import parameters
from img_recog.settings import ParameterError


def test_a_namespace_that_cannot_be_read_is_named(monkeypatch):
    def fault(*_):
        raise xmlrpc.client.Fault(1, 'int exceeds XML-RPC limits')
    monkeypatch.setattr(rospy, 'get_param', fault)
    with pytest.raises(ParameterError) as caught:
        parameters.names_in('/color_extract')
    assert 'parameters in /color_extract: ' in str(caught.value)
    assert 'rosparam delete /color_extract/NAME' in str(caught.value)
    assert '\n' not in str(caught.value)
