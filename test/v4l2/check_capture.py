"""Start, stop, loss and end of the capture, and a device that does not exist."""
import os
import time

from diagnostic_msgs.msg import DiagnosticStatus

from camera_node import PROGRAM, call, log_lines, time_of
from img_recog_testing.waiting import wait_for
from vivid import BRIGHTNESS, PERCENTAGE_DROPPED, descriptors

# The node promises 2 s; the rest is for a guest that is emulated in software.
_LOSS_TIMEOUT_S = _EXIT_TIMEOUT_S = 2.0 + 1.5
_ROUNDS = 20


def check_missing(report, ros, vivid):
    """Check that a device that does not exist ends the node with one line."""
    missing = next(path for path in map('/dev/video{}'.format, range(7, 100))
                   if not os.path.exists(path))
    node = ros.start(PROGRAM, '__name:=missing', '_video_device:=' + missing)
    with report.check('a device that is missing', node) as measured:
        code = node.wait()
        errors = log_lines(node, r'\[FATAL\]')
        measured.extend(errors)
        assert code == 1 and len(errors) == 1, (code, errors)
        assert missing + ':' in errors[0], errors
        assert vivid.path in errors[0].partition('(have ')[2], errors


def check_rounds(report, vivid, node, images):
    """Check that start_capture and stop_capture open and close the device, and leak nothing."""
    with report.check('{} rounds of stop_capture and start_capture'.format(_ROUNDS),
                      node) as measured:
        counts = []
        for _ in range(_ROUNDS):
            call('/usb_cam/stop_capture')
            assert not vivid.held_by(node), 'stopped, and the device is open'
            counts.append(len(descriptors(node)))
            call('/usb_cam/start_capture')
            images.wait_more(2)
            assert vivid.held_by(node) == 1, descriptors(node)
        for service in ('start', 'stop', 'stop'):
            call('/usb_cam/{}_capture'.format(service))
        # a connection of a service client may close later
        wait_for(lambda: len(descriptors(node)) <= counts[0],
                 lambda: 'descriptors: {} {}'.format(counts, descriptors(node)))
        measured.append('descriptors {} to {}, then {}'.format(
            min(counts), max(counts), len(descriptors(node))))
    with report.check('the device is free while stopped', node):
        before = len(images.stamps)
        assert vivid.streams(), 'no frame for another program'
        assert len(images.stamps) == before, 'images though it is stopped'
        call('/usb_cam/start_capture')
        images.wait_more(2)


def check_losses(report, vivid, node, images, diagnostics):
    """Check a device that is unplugged or silent, and its return by a symlink."""
    losses = (('unplugged', vivid.unplug, vivid.plug),
              ('silent', lambda: vivid.set(PERCENTAGE_DROPPED, 100),
               lambda: vivid.set(PERCENTAGE_DROPPED, 0)))
    for number, (name, lose, restore) in enumerate(losses, 1):
        with report.check('{}: logged once and in time'.format(name), node) as measured:
            diagnostics.wait(DiagnosticStatus.OK, 'Hz')
            lose()
            errors = wait_for(
                lambda: log_lines(node, r'\[ERROR\].*camera lost: ')[number - 1:],
                lambda: 'the loss in ' + node.output)
            late_s = time_of(errors[0]) - images.stamps[-1] / 1e9
            measured.append('{:.2f} s after the last image'.format(late_s))
            assert late_s < _LOSS_TIMEOUT_S, measured
            measured.append('diagnostics: ' + diagnostics.wait(
                DiagnosticStatus.ERROR, 'no frame', 4))
            errors = log_lines(node, 'camera lost: ')
            assert len(errors) == number, errors
        with report.check('{}: back without a restart'.format(name), node) as measured:
            begin = time.monotonic()
            restore()
            images.wait_more(5)
            measured.append('images {:.1f} s after it was'.format(time.monotonic() - begin))
            wait_for(lambda: len(log_lines(node, 'camera is back')) == number,
                     'the return in the log')
            measured.append('diagnostics: ' + diagnostics.wait(DiagnosticStatus.OK, 'Hz'))
            assert vivid.get(BRIGHTNESS) == 99, 'brightness is {}'.format(vivid.get(BRIGHTNESS))
    _check_interrupt(report, vivid, node, images)
    vivid.set(PERCENTAGE_DROPPED, 0)


def _check_interrupt(report, vivid, node, images):
    with report.check('SIGINT while the device is silent', node) as measured:
        vivid.set(PERCENTAGE_DROPPED, 100)
        wait_for(lambda: time.time() - images.stamps[-1] / 1e9 > 0.5, 'the device to fall silent')
        begin = time.monotonic()
        code = node.interrupt()
        taken_s = time.monotonic() - begin
        measured.append('exit code {} after {:.2f} s'.format(code, taken_s))
        assert code == 0 and taken_s < _EXIT_TIMEOUT_S, measured
        crashes = log_lines(node, 'Traceback|terminate called|FATAL')
        assert not crashes, crashes
