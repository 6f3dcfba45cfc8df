#!/usr/bin/env python3
"""Run roslaunch for ./run demo and supervise it.

Forwards the output of roslaunch and the nodes, reports which node has ended with an error and
why, and leaves no process behind: if roslaunch is interrupted while it starts nodes, it may wait
for its own locks for minutes.
"""
import contextlib
import os
import pty
import re
import select
import selectors
import signal
import subprocess
import sys
import tempfile
import termios
import time

import demo_master
import full_disk
from demo_arguments import ArgumentError, Arguments

from img_recog import files
from img_recog.command_line.messages import message
from img_recog.errors import UserError, one_line
from img_recog.processes import display, launch_output, process_tree, signals

# Seconds after Ctrl-C, and the signal that is sent to all processes then. roslaunch has the time
# before the first one to stop its nodes itself.
_ESCALATION = tuple(
    (after_s * float(os.environ.get('IMG_RECOG_END_SCALE', '1')), signum)   # for tests
    for after_s, signum in ((4.5, signal.SIGINT), (7.0, signal.SIGTERM), (8.5, signal.SIGKILL)))
_POLL_PERIOD_S = 0.1
_LOG_BYTES = 1 << 20        # of a short demo
_CHUNK_BYTES = 4096         # what a pipe that poll reports as writable takes without blocking
_MAX_UNSENT_BYTES = 1 << 16
_FLUSH_TIMEOUT_S = 1.0
# longer than roslaunch takes to say that it starts the node again
_NOTICE_DELAY_S = 1.2
# after roslaunch has started a node, without starting another one; a page says that it is there
_HINT_DELAY_S = 4.0
_WAIT_NOTICE_S = 3.0        # after Ctrl-C; normally nothing is left then


class Channel:
    """An output of this process, and a pseudo terminal or pipe that is forwarded to it.

    It is a pseudo terminal if the output is a terminal. A reader of the output that does not read
    never blocks this process.
    """

    def __init__(self, target, read_line):
        self._target = target
        self._read_line = read_line
        self._line = self._unsent = b''
        self.disk = full_disk.FullDiskFilter()
        if os.isatty(target):
            self.reader, self.writer = pty.openpty()
            attributes = termios.tcgetattr(self.writer)
            attributes[1] &= ~termios.OPOST         # the real terminal does that
            termios.tcsetattr(self.writer, termios.TCSANOW, attributes)
        else:
            self.reader, self.writer = os.pipe()

    def pass_on(self):
        """Forward the data that has arrived; return False at the end of the stream."""
        try:
            data = os.read(self.reader, 65536)
        except OSError:         # how the end of a pseudo terminal is reported
            data = b''
        has_ended, data = not data, self.disk.passed(data)
        *lines, self._line = (self._line + data).split(b'\n')
        self._unsent += data
        self.flush()
        for line in lines:
            self._read_line(line.decode(errors='replace'))
        return not has_ended

    def say(self, text):
        """Write a line with the prefix [run]."""
        start = '\n' if self._line else ''
        self._unsent += '{}[run] {}\n'.format(start, text).encode()
        self.flush()

    def is_full(self):
        """Return whether the reader of the output is too far behind to take more."""
        return len(self._unsent) > _MAX_UNSENT_BYTES

    def drop(self):
        """Drop what could not be written yet."""
        self._unsent = b''

    def flush(self, timeout_s=0.0):
        """Write what the output takes within a time; keep the rest."""
        end = time.monotonic() + timeout_s
        poll = select.poll()
        poll.register(self._target, select.POLLOUT)
        while self._unsent and poll.poll(max(0.0, end - time.monotonic()) * 1000):
            try:
                written = os.write(self._target, self._unsent[:_CHUNK_BYTES])
            except BlockingIOError:     # a descriptor that somebody made non-blocking
                return
            self._unsent = self._unsent[written:]


class Supervisor:
    """Runs a command until it ends; after a signal, ends it within 10 s."""

    def __init__(self):
        self._output = launch_output.LaunchOutput()
        self._deaths = []
        self._noticed = 0           # number of deaths that were reported
        self._notice_at = None
        self._hint_at = None        # when to say what to do with a demo that has started
        self._has_page = self._has_hinted = False
        self._signals = []
        self._stopped_at = None
        self._stopped_by = None
        self._sent = 0              # number of steps of _ESCALATION that were done
        self._has_said_waiting = self._has_said_full = False
        self._code = None
        self._channels = []

    def run(self, command):
        """Run roslaunch, the command; return its exit code when none of its processes is left."""
        process_tree.adopt_orphans()
        signals.handle(lambda received, _: self._signals.append(received),
                       (*signals.ENDING, signal.SIGQUIT))
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
        roslaunch = self._start(command)
        with selectors.DefaultSelector() as selector:
            for channel in self._channels:
                selector.register(channel.reader, selectors.EVENT_READ, channel)
            while self._goes_on(roslaunch, selector):
                for key, _ in selector.select(_POLL_PERIOD_S):
                    self._pass_on(selector, key.data)
                self._take_signals(roslaunch)
                self._escalate(roslaunch)
                self._give_notice()
                self._give_hint()
        self._repeat_reasons()
        for channel in self._channels:
            with contextlib.suppress(OSError):
                channel.flush(_FLUSH_TIMEOUT_S)
        return self._exit_code()

    def _exit_code(self):
        if any(death.required for death in self._deaths):
            return 1                # for roslaunch this is not an error
        # roslaunch itself gives 1, or is killed, if it is interrupted while it starts
        if self._stopped_by:
            return 0
        return self._code if self._code >= 0 else 128 - self._code

    def _start(self, command):
        channels = [Channel(1, self._read_line)]
        if not os.path.sameopenfile(1, 2):
            channels.append(Channel(2, self._read_line))
        roslaunch = subprocess.Popen(      # in a new session: only we send it SIGINT
            command, stdout=channels[0].writer, stderr=channels[-1].writer,
            start_new_session=True, preexec_fn=process_tree.end_with_parent)
        for channel in channels:
            os.close(channel.writer)
        self._channels = channels
        return roslaunch.pid

    def _goes_on(self, roslaunch, selector):
        """Return whether a process is running, or output is left to forward."""
        ended = process_tree.reap()
        if roslaunch in ended:
            self._code = ended[roslaunch]
            self._stopped_at = self._stopped_at or time.monotonic()
        if self._code is None:
            return True
        if process_tree.descendants():
            return True
        while selector.get_map() and selector.select(0):
            for key, _ in selector.select(0):
                self._pass_on(selector, key.data)
        return False

    def _pass_on(self, selector, channel):
        if channel.is_full():
            if self._stopped_at is None:
                channel.flush(_POLL_PERIOD_S)       # the nodes wait, as for the output itself
                return
            channel.drop()
        try:
            more = channel.pass_on()
        except OSError:             # the terminal or the pipe is closed
            more = False
            self._signals.append(signal.SIGTERM)
        if channel.disk.reason and not self._has_said_full:
            self._has_said_full = True
            self._say(cannot_log(channel.disk.reason))
        if not more:
            selector.unregister(channel.reader)
            os.close(channel.reader)

    def _take_signals(self, roslaunch):
        while self._signals:
            signum = self._signals.pop(0)
            if self._stopped_at is None:
                self._stopped_at = time.monotonic()
                self._stopped_by = signum
                # before roslaunch starts processes, it prints a traceback on SIGINT
                gentle = signal.SIGINT if signum == signal.SIGQUIT else signum
                process_tree.send(gentle if self._output.launching else signal.SIGTERM,
                                  [roslaunch])
            elif self._sent < len(_ESCALATION):     # another signal: next step now
                self._stopped_at = min(self._stopped_at,
                                       time.monotonic() - _ESCALATION[self._sent][0])

    def _escalate(self, roslaunch):
        """Send the next signal of _ESCALATION to all processes when it is due."""
        if self._stopped_at is None:
            return
        if self._code is not None and self._sent == 0:      # only orphans are left
            self._stopped_at = min(self._stopped_at, time.monotonic() - _ESCALATION[0][0])
        waited_s = time.monotonic() - self._stopped_at
        if self._code is None and waited_s > _WAIT_NOTICE_S and not self._has_said_waiting:
            self._has_said_waiting = True
            self._say(message('waiting until all nodes have ended, at most 10 s'))
        while self._sent < len(_ESCALATION) and waited_s >= _ESCALATION[self._sent][0]:
            signum = _ESCALATION[self._sent][1]
            self._sent += 1
            process_tree.send(signum, reversed(process_tree.descendants()))
        if self._sent == len(_ESCALATION):          # started meanwhile
            process_tree.send(signal.SIGKILL, process_tree.descendants())

    def _read_line(self, line):
        line = launch_output.plain(line)
        if re.match(r'process\[(?!master\]|rosout-)', line):
            self._has_page = self._has_page or line.startswith('process[web-')
            self._hint_at = None if self._has_page else time.monotonic() + _HINT_DELAY_S
        elif line.startswith('the page: '):
            self._hint_at = time.monotonic()
        death = self._output.read(line)
        if death is None or self._stopped_by is not None:
            return
        if not death.is_over:
            # roslaunch has reported the death of the same node in the line before
            self._deaths = [each for each in self._deaths if each.node != death.node]
            self._noticed = min(self._noticed, len(self._deaths))
        elif not any(earlier.required for earlier in self._deaths):
            self._deaths.append(death)
            self._notice_at = time.monotonic() + _NOTICE_DELAY_S

    def _give_hint(self):
        """Say once, below the lines of the start, what to do with the demo."""
        if self._has_hinted or self._stopped_at is not None or self._hint_at is None:
            return
        if time.monotonic() >= self._hint_at:
            self._has_hinted = True
            self._say(message('the ROS tools work in ./run shell, in a second terminal'))
            self._say(message('Ctrl-C stops the demo'))

    def _give_notice(self):
        """Report which node has ended while the other nodes continue."""
        if self._notice_at is not None and time.monotonic() > self._notice_at:
            self._notice_at = None
            for death in self._deaths[self._noticed:]:
                if not death.required:          # else _repeat_reasons reports it
                    self._say(message('{}; the other nodes continue',
                                      launch_output.describe(death)))
            self._noticed = len(self._deaths)

    def _repeat_reasons(self):
        """Report below the output of roslaunch which nodes ended, or why none began."""
        for death in self._deaths:
            self._say(launch_output.describe(death))
        if self._output.exception and not (self._output.launching or self._stopped_by):
            self._say(message('roslaunch has ended: {}', self._output.exception))

    def _say(self, text):
        with contextlib.suppress(OSError):
            self._channels[-1].say(text)


def check_files(words):
    """Raise UserError for a file that roslaunch itself cannot load: its errors have many lines.

    words: as returned by Arguments.checked. Without such words, nothing is imported.
    """
    given = dict(word.split(':=', 1) for word in words if ':=' in word)
    if os.path.isabs(given.get('camera', '')):
        from img_recog.camera import selection
        selection.find(given['camera'], [''])
    if os.path.isabs(given.get('robots', '')):
        from img_recog.loading import resources
        from img_recog.nodes.robots import robot_list
        robot_list.read_robots(given['robots'], {}, resources.find)
    if 'colors' in given:
        from img_recog.recognition import parameter_file
        parameter_file.read(given['colors'])
    if 'urdf' in given:
        from img_recog.formats.markup import MarkupError, parse_xml
        from img_recog.loading import robot_file
        try:
            parse_xml(robot_file.read(given['urdf']))
        except MarkupError as error:
            raise UserError('cannot use the robot in {}: {}'.format(given['urdf'], error.problem),
                            error.advice)
    if 'world' in given:
        from img_recog.formats import world_file
        from img_recog.loading import resources, robot_file
        world_file.read(given['world'], resources.worlds(), resources.find, allow_partial=True,
                        read_file=robot_file.read_any)


def log_folder():
    """Return where roslaunch and the nodes write their log."""
    home = os.environ.get('ROS_HOME') or os.path.expanduser('~/.ros')
    return os.environ.get('ROS_LOG_DIR') or os.path.join(home, 'log')


def cannot_log(reason):
    """Return the error for a full disk of the log."""
    return UserError(message('cannot write the log in {}: {}', log_folder(), reason),
                     message('free some space, or set ROS_HOME to another folder'))


def check_log_folder():
    """Raise UserError if the disk of the log is full: roslaunch and the master then print
    hundreds of tracebacks a second.
    """
    folder = log_folder()
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(_LOG_BYTES))
    except OSError as error:
        if error.errno in files.DISK_ERRORS:    # else the nodes say it, and go on without a log
            raise cannot_log(one_line(error))


def check_display():
    """Have the page in place of windows, with a line, if DISPLAY names no X server."""
    reason = display.problem() if os.environ.get('DISPLAY') else ''
    if reason:
        sys.stdout.write('[run] {}\n'.format(message(
            '{}: no windows, but the page; start the X server or log in with ssh -X', reason)))
        sys.stdout.flush()
        del os.environ['DISPLAY']


def main(launch_file, *words):
    """Run the demo with these arguments; return the exit code."""
    signals.handle(signal.default_int_handler)
    try:
        sys.stdout.write('[run] {}\n'.format(message('starting; press Ctrl-C to stop')))
        sys.stdout.flush()
        checked = Arguments(launch_file).checked(words)
        check_files(checked)
        check_log_folder()
        check_display()
        claim = demo_master.Claim(checked)
    except (ArgumentError, UserError) as error:
        sys.stderr.write('[run] {}\n'.format(error))
        return 1
    except KeyboardInterrupt:
        return 0
    with contextlib.closing(claim):
        return Supervisor().run(
            ['roslaunch', '--no-summary', 'img_recog', 'demo.launch', *checked])


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
