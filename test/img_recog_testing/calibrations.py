"""Calibrations for tests: a good one, and how each of its entries can be wrong."""
from img_recog.camera.calibration import Calibration

KNOWN = Calibration(
    camera_name='head_camera', width=640, height=480, distortion_model='plumb_bob',
    distortion=(0.1, -0.25, 1e-05, 0.0, 1 / 3),
    camera_matrix=(500.5, 0.0, 320.0, 0.0, 501.25, 240.0, 0.0, 0.0, 1.0),
    rectification=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    projection=(500.5, 0.0, 320.0, -1e-17, 0.0, 501.25, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0))
OTHER = Calibration('other', 320, 240, 'rational_polynomial', (0.5,) * 8, (2.0,) * 9, (3.0,) * 9,
                    (4.0,) * 12)

# (fields of KNOWN to replace, what the error line says)
BROKEN = [
    ({'width': 0}, r'image_width \(wants a whole number above 0, has 0\)'),
    ({'height': -480}, r'image_height \(wants a whole number above 0, has -480\)'),
    ({'camera_matrix': (float('nan'),) + KNOWN.camera_matrix[1:]},
     r'camera_matrix \(wants finite numbers, has nan\)'),
    ({'projection': KNOWN.projection[:-1] + (float('inf'),)},
     r'projection_matrix \(wants finite numbers, has inf\)'),
    ({'camera_matrix': (0.0,) * 9},
     r'camera_matrix \(wants a focal length fx above 0, has 0\)'),
    ({'distortion_model': 'plum_bob'},
     r"distortion_model \(wants one of .*plumb_bob, rational_polynomial, has 'plum_bob'\)"),
    ({'distortion_model': ''}, r"distortion_model \(wants one of .*, has ''\)"),
    ({'distortion': ()},
     r'distortion_coefficients \(wants 5 or 4 numbers for plumb_bob, has 0\)'),
    ({'distortion': (0.1,) * 3},
     r'distortion_coefficients \(wants 5 or 4 numbers for plumb_bob, has 3\)'),
    ({'distortion_model': 'equidistant'},
     r'distortion_coefficients \(wants 4 numbers for equidistant, has 5\)'),
]
