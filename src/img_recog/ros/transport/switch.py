"""The switch between the fast transport of this folder and plain rospy."""
import os

from img_recog.errors import UserError

VARIABLE = 'IMG_RECOG_PLAIN_ROSPY'
PARTS = ('direct_publisher', 'image_publisher', 'image_subscriber', 'own_time', 'registration',
         'rosout', 'settled_subscriber')


def is_plain(part: str) -> bool:
    """Return whether a part of this folder uses only rospy's documented interface.

    part: one of PARTS.
    Raises UserError when the variable has a value that is not allowed.
    """
    value = os.environ.get(VARIABLE, '')
    if value in ('', '0', '1'):
        return value == '1'
    names = [name.strip() for name in value.split(',')]
    unknown = sorted(set(names) - set(PARTS))
    if unknown:
        raise UserError('{}: got {!r}, allowed is 1 or a list of {}'.format(
            VARIABLE, value, ', '.join(PARTS)))
    return part in names
