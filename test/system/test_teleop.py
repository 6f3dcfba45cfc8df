"""The keyboard teleop in a terminal, while the demo runs another one without a terminal."""
import fcntl
import functools
import os
import pty
import termios

from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.waiting import wait_for

NAME = '/turtlebot3_teleop_keyboard'


class Terminal:
    """A pseudo terminal with the teleop in its foreground, as a user would start it."""

    def __init__(self, ros, *arguments, start=None):
        """start: of Ros, a function that starts another program with the teleop."""
        descriptor, terminal = pty.openpty()
        self._file = os.fdopen(descriptor, 'wb', buffering=0)
        self.process = (start or functools.partial(ros.start_node, 'teleop_key.py'))(
            *arguments, stdin=terminal, start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        os.close(terminal)
        self.type, self.wait = self._file.write, self.process.wait
        self.hang_up = self._file.close         # like when its window is closed
        ros.stack.callback(self.hang_up)

    def echoes(self):
        """Return whether the terminal shows typed keys and waits for Enter, like in a shell."""
        flags = termios.tcgetattr(self._file)[3]
        return bool(flags & termios.ECHO) and bool(flags & termios.ICANON)


LINEAR_X, ANGULAR_Z = 0, 5


def values(echo, column=LINEAR_X):
    """Return the values of a field of a Twist, in order."""
    return [row[column] for row in list(echo.rows)]


def test_started_by_hand_it_takes_over_drives_and_stops(ros):
    demo = ros.demo('camera:=none', 'recognition:=false')
    demo.wait_output('no terminal to read keys from')
    demo.wait_output('simulating 1.0017 kg')
    echo = Echo(ros, '/cmd_vel')
    wait_for(lambda: values(echo)[:5] == [0.0] * 5, lambda: echo.rows[-9:])

    terminal = Terminal(ros)
    demo.wait_output(r'\[respawn\] turtlebot3_teleop_keyboard: ended and is not started '
                     'again: another node has taken its name')
    wait_for(lambda: not terminal.echoes(), lambda: 'the teleop to read single keys')
    # the first one may not be connected to this publisher yet
    echo = Echo(ros, '/cmd_vel')
    wait_for(lambda: values(echo)[:1] == [0.0], lambda: echo.rows[-9:])
    terminal.type(b'w')
    wait_for(lambda: values(echo)[-1] == 0.01, lambda: echo.rows[-9:])
    moving = [value for value in values(echo) if value]
    assert moving[:2] == [0.005, 0.01]
    terminal.type(b'aa')
    wait_for(lambda: values(echo, ANGULAR_Z)[-1] == 0.2, lambda: echo.rows[-9:])
    terminal.type(b's')
    wait_for(lambda: values(echo, ANGULAR_Z)[-1] == 0.0, lambda: echo.rows[-9:])
    assert values(echo)[-1] == 0.0
    terminal.type(b'wwww')
    wait_for(lambda: values(echo)[-1] == 0.04, lambda: echo.rows[-9:])
    terminal.type(b'\x03')
    assert terminal.wait() == 0
    wait_for(lambda: values(echo)[-1] == 0.0, lambda: echo.rows[-9:])
    assert terminal.echoes()
    wait_for(lambda: leaves_no_name(ros), 'an end after which the name is gone')

    # closing its terminal stops the robot, too
    echo, terminal = Echo(ros, '/cmd_vel'), Terminal(ros)
    wait_for(lambda: values(echo)[:1] == [0.0], lambda: echo.rows[-9:])
    wait_for(lambda: not terminal.echoes(), lambda: 'the teleop to read single keys')
    terminal.type(b'www')
    wait_for(lambda: values(echo)[-1] == 0.03, lambda: echo.rows[-9:])
    terminal.hang_up()
    wait_for(lambda: values(echo)[-1] == 0.0, lambda: echo.rows[-9:])
    assert terminal.wait() == 0


def leaves_no_name(ros):
    """Return whether the teleop has left no name; else start and end it once more.

    It ends without the answer of a master that is busy; its name then stays.
    """
    if not ros.master().lookupNode('/test', NAME)[2]:
        return True
    terminal = Terminal(ros)
    wait_for(lambda: not terminal.echoes(), 'the teleop to read single keys')
    terminal.type(b'\x03')
    assert terminal.wait() == 0
    return False


def test_in_the_namespace_of_a_robot_it_drives_only_that_robot(ros):
    ros.start_core()
    terminal = Terminal(ros, '__ns:=tb3_1')
    wait_for(lambda: not terminal.echoes(), 'the teleop')
    echo = Echo(ros, '/tb3_1/cmd_vel')
    wait_for(lambda: values(echo)[:1] == [0.0], lambda: echo.rows[-9:])
    terminal.type(b'w')
    wait_for(lambda: values(echo)[-1] == 0.01, lambda: echo.rows[-9:])
    published = dict(ros.master().getSystemState('/test')[2][0])
    assert '/cmd_vel' not in published and '/tb3_1/cmd_vel' in published


def test_the_launch_file_of_the_teleop_reads_the_keys_of_its_terminal(ros):
    terminal = Terminal(ros, 'img_recog', 'teleop.launch', start=ros.roslaunch)
    wait_for(lambda: not terminal.echoes(), 'the teleop to read single keys')
    terminal.process.wait_output('w/x: faster')
    terminal.type(b'w')
    terminal.process.wait_output('target: linear 0.01')
    terminal.type(b'\x03')
    assert terminal.wait() == 0
    assert terminal.echoes()
