"""The names that a model, a link or a joint can have."""
import re

from img_recog.errors import SimulationError, shortened
from img_recog.model import Model

# PyBullet 3.2.7 cuts names of 1024 bytes and crashes soon after: at 1100 for that of a robot
_MAX_BYTES = 500
_SHOWN = 40         # characters in a message
_NOT_IN_XML = re.compile('[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
# what no service finds again: :: divides the names of a model and of its link
_NOT_OF_MODEL = re.compile('::|[\t\n\r\x7f-\x9f]')


def check_model(name: str) -> None:
    """Raise SimulationError unless a model that is added can have a name."""
    check('model', name)
    if _NOT_OF_MODEL.search(name) or not name.strip():
        raise SimulationError('model_name: got {}, allowed is a text that is not empty, without '
                              ':: and control characters'.format(_begin(repr(name))),
                              'give it another name')


def check(kind: str, name: str) -> None:
    """Raise SimulationError unless a name can be given to PyBullet; kind: of what has it."""
    found = _NOT_IN_XML.search(name)
    if found:
        raise SimulationError('the name of a {}, {}, has the character {!r}, which XML does not '
                              'allow'.format(kind, _begin(name), found.group()),
                              'give a name without control characters')
    length = len(name.encode())
    if length > _MAX_BYTES:
        raise SimulationError('the name of a {} that begins with {} has {} bytes, allowed are {}'
                              .format(kind, _begin(name), length, _MAX_BYTES),
                              'give a shorter name')


def check_all(model: Model) -> None:
    """Check the names in a model, those of its links and joints and its own."""
    check('robot or model', model.name)
    for link in model.links:
        check('link', link.name)
    for joint in model.joints:
        check('joint', joint.name)


def _begin(name: str) -> str:
    return shortened(name[:_SHOWN])
