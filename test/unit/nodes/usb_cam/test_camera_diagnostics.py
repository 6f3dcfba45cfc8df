"""The counters of the camera, and their report."""
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from img_recog.camera.synthetic import SyntheticSource
from img_recog.nodes.usb_cam.usb_cam_node import CameraDiagnostics
from img_recog_helpers.statuses import report


@pytest.fixture
def diagnostics(clock):
    """Diagnostics of a camera that is capturing at 10 Hz."""
    made = CameraDiagnostics('/dev/video5', clock)
    made.opened(SyntheticSource(64, 48, 10.0))
    made.set_active(True)
    return made


def run(diagnostics, clock, seconds, rate_hz):
    """Advance the clock, with frames at this rate and a report each second; return the last."""
    for _ in range(seconds):
        for _ in range(rate_hz):
            clock.advance(1.0 / rate_hz)
            diagnostics.frames.add()
        if not rate_hz:
            clock.advance(1.0)
        last = report(diagnostics)
    return last


def test_rate_is_compared_with_the_expected_one(diagnostics, clock):
    level, message, values = run(diagnostics, clock, 5, 10)
    assert (level, message) == (DiagnosticStatus.OK, '10.0 Hz')
    assert values == {
        'device': '/dev/video5', 'format': 'synthetic scene, 64x48, 10 Hz',
        'frame rate (Hz)': '10.00', 'expected rate (Hz)': '10.00', 'frames': '50',
        'failed reads': '0', 'frames dropped': '0', 'periods late': '0',
        'losses of the device': '0',
        'last failed read': '', 'age of a frame, mean (ms)': 'none',
        'age of a frame, max (ms)': 'none', 'publishing a frame, mean (ms)': 'none',
        'publishing a frame, max (ms)': 'none'}


def test_rate_that_is_too_low_is_a_warning(diagnostics, clock):
    run(diagnostics, clock, 3, 10)
    level, message, _ = run(diagnostics, clock, 5, 6)
    assert level == DiagnosticStatus.WARN and message.startswith('6.0 Hz instead of 10 Hz: ')
    level, message, _ = run(diagnostics, clock, 5, 0)
    assert level == DiagnosticStatus.WARN and message.startswith('no frames: ')
    assert run(diagnostics, clock, 5, 10)[:2] == (DiagnosticStatus.OK, '10.0 Hz')


def test_frames_that_the_node_reads_too_late_are_said_to_be_late(diagnostics, clock):
    run(diagnostics, clock, 3, 10)
    diagnostics.late.add(4)
    level, message, values = run(diagnostics, clock, 5, 6)
    assert (level, message, values['periods late']) == (
        DiagnosticStatus.WARN, '6.0 Hz instead of 10 Hz: the frames are late; a smaller image, a '
        'lower rate or fewer subscribers may help', '4')


def test_lost_device_is_an_error_until_it_is_back(diagnostics, clock):
    run(diagnostics, clock, 3, 10)
    diagnostics.lost('unplugged')
    level, message, values = report(diagnostics)
    assert (level, message) == (
        DiagnosticStatus.ERROR, 'unplugged; connect the camera again')
    assert values['losses of the device'] == '1'
    diagnostics.reconnected()
    assert report(diagnostics)[0] == DiagnosticStatus.OK


def test_stream_is_waited_for_and_has_a_server_not_a_cable(clock):
    diagnostics = CameraDiagnostics('rtsp://camera/live', clock)
    assert report(diagnostics)[:2] == (DiagnosticStatus.OK, 'suspended')
    diagnostics.set_active(True)
    for _ in range(5):
        clock.advance(1.0)
        level, message, values = report(diagnostics)
        assert (level, message) == (DiagnosticStatus.OK, 'waiting for a first frame')
        assert (values['format'], values['frame rate (Hz)']) == ('not open', 'unknown')
    diagnostics.opened(SyntheticSource(64, 48, 10.0))
    assert report(diagnostics)[1] == 'starting'
    assert run(diagnostics, clock, 3, 0)[:2] == (
        DiagnosticStatus.WARN, 'no frames: check its server and the network')
    diagnostics.lost('rtsp://camera/live gives no more frames: ended or silent')
    assert report(diagnostics)[:2] == (
        DiagnosticStatus.ERROR, 'rtsp://camera/live gives no more frames: ended or silent; '
        'check its server and the network')


def test_suspended_camera_is_ok(diagnostics, clock):
    clock.advance(1.0)
    diagnostics.set_active(False)
    assert report(diagnostics)[:2] == (DiagnosticStatus.OK, 'suspended')


def test_skipped_and_dropped_frames_are_counted(diagnostics, clock):
    run(diagnostics, clock, 5, 10)
    for number in range(3):
        diagnostics.skipped.add('cannot decode frame {}'.format(number))
    diagnostics.dropped.add()
    level, message, values = run(diagnostics, clock, 1, 10)
    assert (values['failed reads'], values['frames dropped']) == ('3', '1')
    assert (level, message) == (DiagnosticStatus.WARN, 'failed read: cannot decode frame 2')
    level, _, values = run(diagnostics, clock, 1, 10)
    assert (level, values['last failed read']) == (DiagnosticStatus.OK, 'cannot decode frame 2')


def test_age_and_time_of_publishing(diagnostics):
    for milliseconds in (10, 30):
        diagnostics.ages.add(milliseconds / 1000)
        diagnostics.publishing.add(milliseconds / 10000)
    values = report(diagnostics)[2]
    assert [values['age of a frame, {} (ms)'.format(part)] for part in ('mean', 'max')] == [
        '20.00', '30.00']
    assert [values['publishing a frame, {} (ms)'.format(part)] for part in ('mean', 'max')] == [
        '2.00', '3.00']
