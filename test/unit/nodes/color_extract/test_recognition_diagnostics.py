"""The counters of the recognition, and their report."""
import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from img_recog.nodes.color_extract.color_extract_node import RecognitionDiagnostics
from img_recog_helpers.statuses import report

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@pytest.fixture
def counts(clock):
    return RecognitionDiagnostics('/usb_cam/image_raw', clock)


def run(counts, clock, seconds, received=0, processed=0, refused=0):
    """Report once a second while so many images arrive each second; return the last report."""
    for _ in range(seconds):
        for _ in range(received):
            counts.received.add()
        for _ in range(processed):
            counts.processed.add()
        for _ in range(refused):
            counts.refused.add('no such encoding')
        for _ in range(received - processed - refused):
            counts.replaced.add()
        clock.advance(1.0)
        last = report(counts)
    return last


def test_all_values(counts, clock):
    counts.processing.add(0.002)
    counts.count_latency(100.5, 100.496)
    counts.commands.add()
    level, message, values = run(counts, clock, 1, 10, 9, 1)
    assert (level, message) == (WARN, 'images refused: 1, the last: no such encoding')
    assert values == {
        'images received': '10', 'images received (Hz)': '10.00',
        'images replaced by newer ones': '0', 'images processed': '9',
        'images processed (Hz)': '9.00', 'commands': '1', 'commands (Hz)': '1.00',
        'processing, mean (ms)': '2.00', 'processing, max (ms)': '2.00',
        'stamp to commands, mean (ms)': '4.00', 'stamp to commands, max (ms)': '4.00',
        'images refused': '1', 'last reason': 'no such encoding'}


def test_all_is_well(counts, clock):
    assert run(counts, clock, 4, 30, 30)[:2] == (OK, '30.0 Hz')


def test_silence_is_a_warning(counts, clock):
    assert report(counts)[0] == OK
    assert run(counts, clock, 3)[:2] == (
        WARN, 'no images on /usb_cam/image_raw yet: start a camera')
    assert run(counts, clock, 3, 30, 30)[0] == OK
    assert run(counts, clock, 5)[:2] == (
        WARN, 'no images on /usb_cam/image_raw for 5 s: start a camera')


def test_a_slow_node_is_a_warning(counts, clock):
    assert run(counts, clock, 4, 30, 25)[0] == OK
    level, message, values = run(counts, clock, 4, 30, 20)
    assert level == WARN and message.startswith('too slow: 20.0 of 30.0 images a second'), message
    assert values['images replaced by newer ones'] == '60'


def test_bad_images_are_a_warning_and_without_a_good_one_an_error(counts, clock):
    assert run(counts, clock, 4, 30, 29, 1)[0] == WARN
    assert run(counts, clock, 4, 30, 30)[0] == OK
    level, message, _ = run(counts, clock, 4, 30, 0, 30)
    assert level == ERROR and 'no such encoding' in message and 'check the camera' in message


@pytest.mark.parametrize('now_s, stamp_s', [(100.0, 0.0), (100.0, 101.0), (1000.0, 1.0)])
def test_a_stamp_of_another_clock_is_not_measured(counts, now_s, stamp_s):
    counts.count_latency(now_s, stamp_s)
    assert counts.latency.take() is None
