"""V4L2 controls: those that the parameters set at startup, and those changed while it runs."""
from dynamic_reconfigure.client import Client

from camera_node import log_lines
from vivid import BRIGHTNESS, CONTRAST, GAIN, HUE, SATURATION

# parameters of the node usb_cam, and the controls that they set
CONTROLS = {'brightness': (BRIGHTNESS, 99), 'contrast': (CONTRAST, 120),
            'saturation': (SATURATION, 110), 'gain': (GAIN, 42)}
INTRINSIC_CONTROLS = {'hue': (HUE, 5)}
MISSING_CONTROLS = ('sharpness', 'nonsense')     # a parameter, and one of intrinsic_controls


def parameters():
    """Return the parameters of the node for these checks."""
    sharpness, nonsense = MISSING_CONTROLS
    intrinsic = {name: value for name, (_, value) in INTRINSIC_CONTROLS.items()}
    return {**{name: value for name, (_, value) in CONTROLS.items()}, sharpness: 4,
            'intrinsic_controls': {**intrinsic, nonsense: 3}}


def check_controls(report, vivid, node):
    """Check the controls at startup and by dynamic_reconfigure."""
    with report.check('controls at start', node) as measured:
        expected = {**CONTROLS, **INTRINSIC_CONTROLS}
        values = {name: vivid.get(control_id) for name, (control_id, _) in expected.items()}
        measured.append(values)
        assert values == {name: value for name, (_, value) in expected.items()}, values
    with report.check('controls that the camera lacks: one warning each', node):
        for name in MISSING_CONTROLS:
            warnings = log_lines(node, r'\[WARN\].*the camera has no control {}; '.format(name))
            assert len(warnings) == 1, warnings
    with report.check('controls while it runs, by dynamic_reconfigure', node) as measured:
        client = Client('/usb_cam', timeout=60)
        config = client.update_configuration({'brightness': 77})
        measured.append('brightness {} of {}'.format(vivid.get(BRIGHTNESS), config['brightness']))
        assert vivid.get(BRIGHTNESS) == config['brightness'] == 77, measured
        client.update_configuration({'contrast': 999})
        node.wait_output(r'\[WARN\].*control contrast: got 999, allowed is 0 to 255')
        client.update_configuration({'contrast': 121, 'brightness': 99})
        assert (vivid.get(CONTRAST), vivid.get(BRIGHTNESS)) == (121, 99)
        warnings = log_lines(node, 'no control sharpness')
        measured.append('{} warnings of the missing control'.format(len(warnings)))
        client.close()
