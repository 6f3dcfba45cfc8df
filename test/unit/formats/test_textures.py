"""Images of materials."""
import numpy as np
import pytest
from PIL import Image

from img_recog.formats import materials


@pytest.mark.parametrize('size, shape', [((4096, 2), (2, 4096, 3)), ((2, 8192), (4096, 1, 3))])
def test_a_large_image_is_reduced(tmp_path, size, shape):
    path = str(tmp_path / 'a.png')
    Image.new('RGB', size, (1, 2, 3)).save(path)
    found = materials.read_texture(path)
    assert found.shape == shape and (found == (1, 2, 3)).all()


def test_channels(tmp_path):
    path = str(tmp_path / 'a.png')
    Image.fromarray(np.array([[(9, 8, 7, 6)]], np.uint8)).save(path)
    assert materials.read_texture(path).tolist() == [[[9, 8, 7]]]
    assert materials.read_texture(path, 'RGBA').tolist() == [[[9, 8, 7, 6]]]
