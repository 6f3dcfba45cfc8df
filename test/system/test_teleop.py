"""The keyboard teleop in a terminal, while the demo runs another one without a terminal."""
import fcntl
import os
import pty
import re
import termios

from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.waiting import wait_for

NAME = '/turtlebot3_teleop_keyboard'


class Terminal:
    """A pseudo terminal with the teleop in its foreground, as a user would start it."""

    def __init__(self, ros, *arguments):
        descriptor, terminal = pty.openpty()
        self._file = os.fdopen(descriptor, 'wb', buffering=0)
        process = ros.start_node('teleop_key.py', *arguments, stdin=terminal,
                                 start_new_session=True,
                                 preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        os.close(terminal)
        self.type, self.wait = self._file.write, process.wait
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


def leaves_no_name(ros):
    """Return whether the teleop has left no name; else start and end it once more.

    It ends without the answer of a master that is busy; its name then stays.
    """
    if re.search(r'(?m)^' + NAME, ros.run('rosnode', 'list')) is None:
        return True
    terminal = Terminal(ros)
    wait_for(lambda: not terminal.echoes(), 'the teleop to read single keys')
    terminal.type(b'\x03')
    assert terminal.wait() == 0
    return False


def test_closing_its_terminal_stops_the_robot(ros):
    ros.demo('camera:=none', 'recognition:=false', 'teleop:=false').wait_output('simulating')
    echo = Echo(ros, '/cmd_vel')
    terminal = Terminal(ros)
    wait_for(lambda: values(echo)[:1] == [0.0], lambda: echo.rows[-9:])
    wait_for(lambda: not terminal.echoes(), lambda: 'the teleop to read single keys')
    terminal.type(b'www')
    wait_for(lambda: values(echo)[-1] == 0.03, lambda: echo.rows[-9:])
    terminal.hang_up()
    wait_for(lambda: values(echo)[-1] == 0.0, lambda: echo.rows[-9:])
    assert terminal.wait() == 0


def test_in_the_namespace_of_a_robot_it_drives_only_that_robot(ros):
    demo = ros.demo('robots:=2', 'camera:=none', 'recognition:=false', 'teleop:=false',
                    'world:=empty')
    demo.wait_output(r'process\[tb3_1/robot_state_publisher-\d\]: started')
    speeds = {name: Echo(ros, '/{}/odom/twist/twist'.format(name))
              for name in ('tb3_0', 'tb3_1')}
    terminal = Terminal(ros, '__ns:=tb3_1')
    wait_for(lambda: not terminal.echoes(), 'the teleop')
    wait_for(lambda: all(values(each) for each in speeds.values()),
             'the speeds of both')
    terminal.type(b'w' * 10)
    wait_for(lambda: max(values(speeds['tb3_1']), default=0) > 0.09,
             lambda: speeds['tb3_1'].rows[-9:])
    count = len(values(speeds['tb3_0']))
    wait_for(lambda: len(values(speeds['tb3_0'])) > count + 10,
             'newer speeds of the first robot')
    assert max(map(abs, values(speeds['tb3_0']))) < 0.01
    assert demo.interrupt() == 0
