"""What is wrong with this machine; works without ROS and without the libraries of the nodes."""
import contextlib
import errno
import glob
import importlib.util
import os
import shlex
import shutil
import socket
import subprocess
import sys
import tempfile
import urllib.parse
from typing import Iterator, NamedTuple, Set

from img_recog.command_line.messages import message
from img_recog.errors import one_line, shortened

LIBRARIES = ('av', 'cv2', 'cv_bridge', 'moderngl', 'nicegui', 'numpy', 'pybullet', 'rospkg',
             'tf2_ros', 'trimesh', 'xacro', 'yaml')
MESSAGE_PACKAGES = ('diagnostic_msgs', 'geometry_msgs', 'nav_msgs', 'rosgraph_msgs', 'sensor_msgs',
                    'std_msgs', 'std_srvs', 'tf2_msgs', 'visualization_msgs')
DEFAULT_MASTER = 'http://localhost:11311'
_SYSTEM_PYTHON = '/usr/bin/python3'     # the one that the packages of ROS are for
_NOETIC = '/opt/ros/noetic'
_MIN_FREE_MB = 200
_TIMEOUT_S = 60


class Fault(NamedTuple):
    """Something that is wrong, and what to do about it.

    is_note: it may be meant to be so.
    """

    problem: str
    advice: str
    is_note: bool = False


def check_python() -> Iterator[Fault]:
    """Report a python3 that is first on PATH and has no rospy, as those of pyenv and conda."""
    first = shutil.which('python3') or 'python3'
    why = _failure(first, 'import rospy')
    if why and not _failure(_SYSTEM_PYTHON, 'import rospy'):
        yield Fault(
            message('{} is first on PATH and has no rospy: {}', first, why),
            message('leave pyenv or conda ("conda deactivate"), or run "export '
                    'PATH=/usr/bin:$PATH"; with catkin_make, add '
                    '-DPYTHON_EXECUTABLE=/usr/bin/python3'))
    elif why:
        yield Fault(message('there is no rospy: {}', why), message(
            'run "./run setup", and source the setup.bash of ROS or of your workspace'))


def check_libraries() -> Iterator[Fault]:
    """Report libraries of the nodes that the interpreter of this program does not find."""
    missing = [name for name in LIBRARIES if not _exists(name)]
    if missing:
        yield Fault(message('{} has no {}', sys.executable, ', '.join(missing)),
                    message('run "./run setup", then "./run build"'))


def check_cv_bridge() -> Iterator[Fault]:
    """Report a cv_bridge that cannot be loaded, as one for numpy 1 beside numpy 2."""
    if not (_exists('numpy') and _exists('cv_bridge')):
        return      # check_libraries reports it
    why = _own_failure('import cv_bridge.boost.cv_bridge_boost')
    if why:
        version = _own_failure('import sys, numpy; sys.exit(numpy.__version__)')
        yield Fault(
            message('cv_bridge cannot be loaded beside numpy {}: {}', version, why),
            message('cv_bridge needs the numpy of the distribution: remove the other one '
                    '("python3 -m pip uninstall numpy"), or run "rm -r .venv" and "./run setup"'))


def check_message_packages() -> Iterator[Fault]:
    """Report packages of messages that the nodes need and that are not installed."""
    yield from missing_packages(set(MESSAGE_PACKAGES))


def missing_packages(names: Set[str]) -> Iterator[Fault]:
    """Report which of these packages of messages Python does not find."""
    missing = [shortened(name) for name in sorted(names) if not _exists(name)]
    if missing:
        package = 'ros-noetic-' if os.path.isdir(_NOETIC) else 'python3-'
        yield Fault(
            message('message packages are missing: {}', ', '.join(missing)),
            message('install them ("sudo apt-get install {}"); those of a workspace: build it and '
                    'source its devel/setup.bash', ' '.join(
                        shlex.quote(package + name.replace('_', '-')) for name in missing)))


def check_camera(pattern: str = '/dev/video*') -> Iterator[Fault]:
    """Report that there is no camera, or none that may be opened."""
    devices = sorted(glob.glob(pattern))
    if not devices:
        yield Fault(
            message('there is no camera: no {}', pattern),
            message('plug one in; in WSL attach it with usbipd, in Docker add --device '
                    '/dev/video0; without one, the demo shows a synthetic scene, or a film by '
                    'camera:=FILE'),
            is_note=True)
    elif not any(os.access(each, os.R_OK | os.W_OK) for each in devices):
        yield Fault(message('no permission to open {}', ', '.join(devices)),
                    message('run "sudo usermod -aG video $USER", then log in again'))


def check_opengl() -> Iterator[Fault]:
    """Report that the images of the simulator cannot be drawn by OpenGL."""
    if _exists('moderngl'):
        why = _own_failure('from img_recog.rendering.opengl import Renderer; Renderer()')
        if why:
            yield Fault(message('images of the simulator cannot be drawn: {}', why),
                        message('run "sudo apt-get install libegl1 libgl1-mesa-dri"'))


def check_disk() -> Iterator[Fault]:
    """Report folders that are full or cannot be written."""
    home = os.environ.get('ROS_HOME') or os.path.expanduser('~/.ros')
    for folder in {os.environ.get('ROS_LOG_DIR') or home, tempfile.gettempdir()}:
        while not os.path.isdir(folder):
            folder = os.path.dirname(os.path.abspath(folder))
        try:
            with tempfile.TemporaryFile(dir=folder) as file:
                file.write(bytes(4096))
        except OSError as error:
            if error.errno != errno.ENOSPC:
                yield Fault(message('cannot write in {}: {}', folder, one_line(error)),
                            message('make it writable for you, or set ROS_HOME to another '
                                    'folder'))
                continue
        free_mb = shutil.disk_usage(folder).free // 1000000
        if free_mb < _MIN_FREE_MB:
            yield Fault(message('the disk of {} is full: {} MB are free', folder, free_mb),
                        message('remove files; "rosclean check" shows the size of the logs, '
                                '"rosclean purge" removes them'))


def check_addresses() -> Iterator[Fault]:
    """Report a ROS_MASTER_URI, ROS_HOSTNAME or ROS_IP that cannot be right."""
    uri = os.environ.get('ROS_MASTER_URI') or DEFAULT_MASTER
    master = None
    with contextlib.suppress(ValueError):
        parts = urllib.parse.urlsplit(uri)
        master = parts.port and parts.scheme == 'http' and parts.hostname
    advice = message('set it to the address of the master, like {}', DEFAULT_MASTER)
    if not master:
        yield Fault(message('ROS_MASTER_URI is {}, expected http://HOST:PORT', shortened(uri)),
                    advice)
    elif not _addresses(master):
        yield Fault(message('ROS_MASTER_URI names {}, which is no computer that this one knows',
                            shortened(master)), advice)
    variable = next((each for each in ('ROS_HOSTNAME', 'ROS_IP') if os.environ.get(each)), '')
    name = os.environ[variable] if variable else socket.gethostname()
    shown = '{}={}'.format(variable, shortened(name)) if variable else name
    own = _addresses(name)
    if not any(map(_is_own, own)):
        yield Fault(
            message('{} is not an address of this computer', shown),
            message('set ROS_IP to one that "hostname -I" shows and unset ROS_HOSTNAME, or run '
                    '"export ROS_HOSTNAME=localhost" if all nodes are on this computer'))
    elif (master and all(map(_is_loopback, own)) and _addresses(master)
          and not any(map(_is_own, _addresses(master)))):
        yield Fault(
            message('{} can be reached on this computer alone, and the master is on {}', shown,
                    shortened(master)),
            message('run "unset ROS_HOSTNAME" and set ROS_IP to the address of this computer that '
                    '"hostname -I" shows'))


CHECKS = (check_python, check_libraries, check_cv_bridge, check_message_packages, check_camera,
          check_opengl, check_disk, check_addresses)


def _exists(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):
        return False


def _failure(python: str, code: str) -> str:
    """Return the last line that code prints if it fails in an interpreter, else ''."""
    try:
        done = subprocess.run([python, '-c', code], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, check=False,
                              timeout=_TIMEOUT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        return one_line(error)
    lines = done.stderr.decode(errors='replace').strip().splitlines()
    return shortened(lines[-1] if lines else done.returncode) if done.returncode else ''


def _own_failure(code: str) -> str:
    """Return the same for this interpreter, with the modules that it finds now."""
    return _failure(sys.executable, 'import sys; sys.path[:] = {!r}; {}'.format(sys.path, code))


def _addresses(name: str) -> Set[str]:
    try:
        return {str(info[4][0]) for info in socket.getaddrinfo(name, 0, type=socket.SOCK_STREAM)}
    except (OSError, UnicodeError):
        return set()


def _is_own(address: str) -> bool:
    family = socket.AF_INET6 if ':' in address else socket.AF_INET
    with contextlib.suppress(OSError), socket.socket(family, socket.SOCK_STREAM) as sock:
        sock.bind((address, 0))
        return True
    return False


def _is_loopback(address: str) -> bool:
    return address.startswith('127.') or address == '::1'
