"""The environment variable that selects plain rospy."""
import pytest

from img_recog.errors import UserError
from img_recog.ros.transport import switch


@pytest.mark.parametrize('value, plain', [
    (None, set()), ('', set()), ('0', set()), ('1', set(switch.PARTS)), ('rosout', {'rosout'}),
    ('rosout, own_time', {'rosout', 'own_time'})])
def test_the_parts_that_are_plain(monkeypatch, value, plain):
    monkeypatch.delenv(switch.VARIABLE, raising=False)
    if value is not None:
        monkeypatch.setenv(switch.VARIABLE, value)
    assert {part for part in switch.PARTS if switch.is_plain(part)} == plain


@pytest.mark.parametrize('value', ['yes', 'rosout,', 'rosout,images'])
def test_the_error_about_a_wrong_value_lists_the_allowed_ones(monkeypatch, value):
    monkeypatch.setenv(switch.VARIABLE, value)
    with pytest.raises(UserError) as error:
        switch.is_plain('rosout')
    assert repr(value) in str(error.value) and 'image_publisher' in str(error.value)
