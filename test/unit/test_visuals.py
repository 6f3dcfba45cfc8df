"""The frames of what is drawn."""
import pytest

from img_recog.visuals import BODY_TO_OPENGL


@pytest.mark.parametrize('body, opengl', [
    ((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (0, 0, -1)), ((0, 1, 0), (-1, 0, 0)),
    ((0, 0, 1), (0, 1, 0))], ids=['origin', 'ahead', 'left', 'up'])
def test_a_camera_body_looks_along_x_and_opengl_along_minus_z(body, opengl):
    assert (BODY_TO_OPENGL @ (*body, 1)).tolist() == [*opengl, 1]
