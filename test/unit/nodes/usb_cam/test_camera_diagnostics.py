"""The diagnostics of the camera, with a fake of diagnostic_updater."""
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.camera.synthetic import SyntheticSource
from img_recog.nodes.usb_cam import diagnostics as camera_diagnostics


class FakeUpdater:
    """Counts how often it publishes."""

    def __init__(self):
        self.published = 0

    def setHardwareID(self, name):
        self.hardware_id = name

    def add(self, name, task):
        self.name, self.task = name, task

    def force_update(self):
        self.published += 1


@pytest.fixture
def diagnostics(clock, monkeypatch):
    """Diagnostics of a camera that is capturing at 10 Hz."""
    monkeypatch.setattr(camera_diagnostics.diagnostic_updater, 'Updater', FakeUpdater)
    made = camera_diagnostics.CameraDiagnostics('/dev/video5', clock)
    made.opened(SyntheticSource(64, 48, 10.0))
    made.update(True)
    return made


def report(diagnostics):
    status = diagnostics.report(DiagnosticStatusWrapper())
    return status.level, status.message, {each.key: each.value for each in status.values}


def run(diagnostics, clock, seconds, rate_hz):
    """Advance the clock, with frames at this rate and a report each second; return the last."""
    for _ in range(seconds):
        for _ in range(rate_hz):
            clock.advance(1.0 / rate_hz)
            diagnostics.count_frame()
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
        'failed reads': '0', 'frames dropped': '0', 'losses of the device': '0'}


def test_rate_that_is_too_low_is_a_warning(diagnostics, clock):
    run(diagnostics, clock, 3, 10)
    assert run(diagnostics, clock, 5, 6)[:2] == (DiagnosticStatus.WARN, '6.0 Hz instead of 10 Hz')
    assert run(diagnostics, clock, 5, 0)[:2] == (DiagnosticStatus.WARN, 'no frames')
    assert run(diagnostics, clock, 5, 10)[:2] == (DiagnosticStatus.OK, '10.0 Hz')


def test_lost_device_is_an_error_until_it_is_back(diagnostics, clock):
    run(diagnostics, clock, 3, 10)
    diagnostics.lost('unplugged')
    level, message, values = report(diagnostics)
    assert (level, message) == (DiagnosticStatus.ERROR, 'unplugged')
    assert values['losses of the device'] == '1'
    diagnostics.reconnected()
    assert report(diagnostics)[0] == DiagnosticStatus.OK


def test_suspended_camera_is_ok(diagnostics, clock):
    clock.advance(1.0)
    diagnostics.update(False)
    assert report(diagnostics)[:2] == (DiagnosticStatus.OK, 'suspended')


def test_skipped_and_dropped_frames_are_counted(diagnostics):
    for _ in range(3):
        diagnostics.count_skipped()
    diagnostics.count_dropped()
    values = report(diagnostics)[2]
    assert (values['failed reads'], values['frames dropped']) == ('3', '1')


def test_published_once_per_second_with_the_device_as_hardware_id(diagnostics, clock):
    for _ in range(50):
        clock.advance(0.2)
        diagnostics.update(True)
    updater = diagnostics._updater
    assert (updater.name, updater.hardware_id) == ('camera', '/dev/video5')
    assert 10 <= updater.published <= 11
