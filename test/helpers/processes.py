"""Programs under test, with a separate ROS master on a free port."""
import contextlib
import copy
import ctypes
import os
import pathlib
import re
import signal
import socket
import subprocess
import threading
import uuid
import xmlrpc.client

from roslib.packages import find_node

from img_recog_helpers import wire
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for


_END_S = 20.0               # until a program that is interrupted is killed
_LAST_OUTPUT_S = 30.0       # of a program that has ended; a child may keep the pipe open
# images of the usual size take more CPU time than all else of the demo
SMALL_CAMERA = 'camera:=synthetic', 'image_width:=320', 'image_height:=240'
_PROGRAMS = os.environ['CMAKE_PREFIX_PATH'].split(os.pathsep)[0] + '/lib/img_recog/'


class Process:
    """A program whose output is collected while it runs."""

    def __init__(self, command, env, **popen):
        self.output = ''
        self._popen = subprocess.Popen(
            [str(word) for word in command], env=env, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, **{'stdin': subprocess.DEVNULL, **popen})
        self.pid, self.stdin = self._popen.pid, self._popen.stdin
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._popen.stdout:
            self.output += line.decode(errors='replace')

    def wait_output(self, pattern):
        """Wait until a regular expression matches the output; return the match."""
        return wait_for(lambda: re.search(pattern, self.output),
                        lambda: '{!r} in:\n{}'.format(pattern, self.output))

    def wait(self):
        """Wait until the program ends by itself; return its exit code."""
        wait_for(lambda: not self.is_running(), lambda: 'the end of:\n' + self.output)
        self._reader.join(_LAST_OUTPUT_S * stretch())
        return self._popen.returncode

    def fatal_line(self):
        """Wait for the end of a program that refuses its input; return its one FATAL line."""
        code = self.wait()
        lines = [line for line in self.output.splitlines() if '[FATAL]' in line]
        assert code == 1 and len(lines) == 1 and 'Traceback' not in self.output, self.output
        return lines[0]

    def is_running(self):
        """Return whether the program has not ended."""
        return self._popen.poll() is None

    def send_signal(self, number):
        """Send a signal."""
        self._popen.send_signal(number)

    def interrupt_thread(self):
        """Send SIGINT to a thread that is not the main one; return the exit code.

        The kernel may choose any thread for a signal to the program.
        """
        threads = {int(name) for name in os.listdir('/proc/{}/task'.format(self.pid))}
        thread = min(threads - {self.pid})      # the newest one may end at once
        assert ctypes.CDLL(None).tgkill(self.pid, thread, signal.SIGINT) == 0, threads
        return self.wait()

    def interrupt(self):
        """Send SIGINT, as Ctrl-C does; wait for the end and return the exit code."""
        self.send_signal(signal.SIGINT)
        return self.wait()

    def close(self, is_interrupted=False):
        """Send SIGINT, unless that is done, and SIGKILL if that does not end the program."""
        if not is_interrupted:
            self.send_signal(signal.SIGINT)
        try:
            self._popen.wait(_END_S * stretch())
        except subprocess.TimeoutExpired:
            self._popen.kill()


class Ros:
    """Starts programs that share one ROS master; use it in a with statement.

    marker: an entry of the environment of all these programs, and of what they start.
    stack: what is closed at the end, before the programs.
    master_uri: of the master, which `start_master` or roslaunch starts.
    """

    def __init__(self, folder):
        """folder: for the logs, and what else ROS keeps."""
        # bound until the end: no other program gets the port before a master listens on it
        self._reserved = socket.socket()
        self._reserved.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._reserved.bind(('127.0.0.1', 0))
        self.port = self._reserved.getsockname()[1]
        self.master_uri = 'http://127.0.0.1:{}'.format(self.port)
        self.marker = 'IMG_RECOG_UNDER_TEST=' + uuid.uuid4().hex
        self.env = dict([*os.environ.items(), self.marker.split('=')],
                        ROS_MASTER_URI=self.master_uri, ROS_HOSTNAME='localhost',
                        ROS_HOME=str(pathlib.Path(folder, 'ros')), PYTHONUNBUFFERED='1')
        self.env.pop('DISPLAY', None)
        self.core = self._rosout = None
        self.processes = []
        self.stack = contextlib.ExitStack()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def beside(self):
        """Return a Ros with the same master; its end ends only what it has started itself."""
        other = copy.copy(self)
        other.processes, other.stack = [], contextlib.ExitStack()
        return other

    def start_master(self):
        """Start a master and rosout, wait until both answer, and return the master's Process.

        roscore does the same, and takes half a second of CPU time more.
        """
        self.start_core()
        self.set_parameters('/run_id', str(uuid.uuid4()))
        self._rosout = self.start(find_node('rosout', 'rosout')[0], '__name:=rosout')
        self.node_pid('/rosout')
        return self.core

    def start_core(self, **popen):
        """Start a master without rosout, and wait until it answers."""
        self.core = self.start('rosmaster', '--core', '-p', self.port, **popen)
        wait_for(lambda: wire.answers(self.master_uri), lambda: 'it in:\n' + self.core.output)

    def kill_master(self, signum=signal.SIGKILL):
        """End the master and rosout by a signal."""
        for process in self._masters():
            process.send_signal(signum)
        for process in self._masters():
            process.wait()

    def _masters(self):
        return [process for process in self.processes if process in (self.core, self._rosout)]

    def start(self, *command, **popen):
        """Start a program and return its Process."""
        process = Process(command, popen.pop('env', self.env), **popen)
        self.processes.append(process)
        return process

    def start_node(self, script, *arguments, **popen):
        """Start a script of this package; rosrun takes half a second of CPU time to find it."""
        return self.start(_PROGRAMS + script, *arguments, **popen)

    def demo(self, *arguments, **popen):
        """Start the demo, by default with a small synthetic camera and without the page."""
        return self.roslaunch('img_recog', 'demo.launch', *SMALL_CAMERA, 'web:=false', *arguments,
                              **popen)

    def roslaunch(self, *words, **popen):
        """Start roslaunch, which kills no node that ends later because the machine is busy."""
        return self.start('roslaunch', '-p', self.port, '--sigint-timeout={}'.format(DEADLINE_S),
                          *words, **popen)

    def run(self, *command):
        """Run a program until it ends; return its output."""
        process = self.start(*command)
        process.wait()
        return process.output

    def wait_run(self, pattern, *command):
        """Run a program again and again until a pattern matches its output; return the match."""
        return wait_for(lambda: re.search(pattern, self.run(*command)),
                        lambda: '{!r} from {}'.format(pattern, command))

    def node_pid(self, name):
        """Wait until a node answers; return its process id. name: with its namespace."""
        return wait_for(lambda: wire.pid_of(self.master_uri, name), 'the node ' + name)

    def master(self):
        """Return the XML-RPC API of the master."""
        return xmlrpc.client.ServerProxy(self.master_uri)

    def parameter(self, name):
        """Return a parameter, or a namespace of them."""
        return self.master().getParam('/test', name)[2]

    def set_parameters(self, name, value=None):
        """Replace a parameter or a namespace of them, by default by nothing.

        rosparam does the same, and takes half a second of CPU time.
        """
        master = self.master()
        if master.hasParam('/test', name)[2]:
            master.deleteParam('/test', name)
        if value is not None:
            assert master.setParam('/test', name, value)[0] == 1

    def close(self):
        """End all programs: the master after the others, which unregister."""
        self.stack.close()
        others = [process for process in self.processes if process not in self._masters()]
        for process in others:
            process.send_signal(signal.SIGINT)      # at once: each takes half a second
        for process in others:
            process.close(is_interrupted=True)
        self.kill_master()
        self._reserved.close()
