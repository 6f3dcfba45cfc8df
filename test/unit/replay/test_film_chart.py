"""Charts in the pictures of a film."""
import numpy as np

from img_recog.replay import film_chart


def test_a_long_legend_has_several_rows():
    picture = np.full((200, 400, 3), 255, np.uint8)
    entries = [('name_{}'.format(number), (0, 0, 200)) for number in range(8)]
    assert film_chart._legend(picture, entries, (60, 388), 32) == 64
    lines = (picture == (0, 0, 200)).all(axis=2)
    assert [lines[y].sum() for y in (32, 48, 64)] == [3 * 23, 3 * 23, 2 * 23]
    assert (picture[:, 389:] == 255).all()
