"""How a function refuses what it cannot use."""
import pytest

from img_recog.errors import UserError


def refusal(function, *arguments, **more):
    """Return the line of the UserError that a function raises."""
    with pytest.raises(UserError) as error:
        function(*arguments, **more)
    line = str(error.value)
    assert '\n' not in line and '\0' not in line and len(line) < 900
    return line
