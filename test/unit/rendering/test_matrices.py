"""Transforms and projections."""
import numpy as np

from img_recog.rendering import matrices


def test_a_point_before_the_camera_has_a_negative_z_in_its_view():
    turn = np.array([0.1, -0.3, 0.3, 0.9])
    pose = matrices.from_poses(np.array([[1.0, -2.0, 0.5, *(turn / np.linalg.norm(turn))]]))[0]
    # x forward, y to the left, z up becomes x to the right, y up, z backward
    seen = matrices.view(pose) @ pose @ (4.0, 1.0, 2.0, 1.0)
    assert np.allclose(seen, (-1.0, 2.0, -4.0, 1.0))
    assert np.allclose(matrices.inverse(pose) @ pose, np.eye(4))
