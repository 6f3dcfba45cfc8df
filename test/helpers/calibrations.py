"""Good calibrations for tests."""
from img_recog.camera.calibration import Calibration

KNOWN = Calibration(
    camera_name='head_camera', width=640, height=480, distortion_model='plumb_bob',
    distortion=(0.1, -0.25, 1e-05, 0.0, 1 / 3),
    camera_matrix=(500.5, 0.0, 320.0, 0.0, 501.25, 240.0, 0.0, 0.0, 1.0),
    rectification=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    projection=(500.5, 0.0, 320.0, -1e-17, 0.0, 501.25, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0))
OTHER = Calibration('other', 320, 240, 'rational_polynomial', (0.5,) * 8, (2.0,) * 9, (3.0,) * 9,
                    (4.0,) * 12)
