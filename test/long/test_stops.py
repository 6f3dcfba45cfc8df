"""Many stops of real nodes; takes about ten minutes."""
import random

import pytest

from img_recog_testing.processes import Ros
from img_recog_testing.stops import stop_after_the_images

_STOPS, _AT_ONCE = 200, 8


@pytest.fixture
def ros(tmp_path):
    """A running master."""
    ros = Ros(tmp_path)
    ros.start('roscore', '-p', ros.port).wait_output('started core service')
    yield ros
    ros.close()


def test_recognitions_end_whose_images_have_just_stopped(ros):
    seed = random.randrange(1 << 32)
    print('seed {}'.format(seed))
    for turn in range(_STOPS // _AT_ONCE):
        stop_after_the_images(ros, _AT_ONCE, seed + turn, deadline_s=60.0)
