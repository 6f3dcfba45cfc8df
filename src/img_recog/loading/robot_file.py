"""Reads the file of a robot: a URDF, or a xacro file, which is expanded to a URDF."""
import contextlib
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import types
from typing import Iterator, List, Optional, Sequence, Tuple, Union

import rospkg

from img_recog.errors import UserError, one_line
from img_recog.files import plain
from img_recog.formats.markup import MarkupError, check_expanded, check_xml, parse_xml, read_bytes

_XACRO = '.xacro'
_TIMEOUT_S = 60.0


def read(path: str, option: str = 'urdf') -> str:
    """Return the text of a URDF.

    path: of a URDF, or of a xacro file, whose name ends with .xacro; arguments of xacro can follow
    that after a space, like 'my.urdf.xacro arm:=true': NAME:=VALUE, or NAME=VALUE, since roslaunch
    takes only one := in an argument. option: what the user types to name the file, for the error.
    Raises UserError when it cannot be read, xacro is missing or fails, or a URDF contains xacro.
    """
    path, arguments = _divided(path)
    if arguments and not path.endswith(_XACRO):
        raise UserError('cannot read the robot in {}: it is no .xacro file, and has no argument {}'
                        .format(path, ' '.join(arguments)), 'set {} to the file'.format(option))
    try:
        content = read_bytes(path)
        text = '' if path.endswith(_XACRO) else _text(content)
    except (OSError, MarkupError) as error:
        raise UserError('cannot read the robot in {}: {}'.format(
            path, error.problem if isinstance(error, MarkupError) else one_line(error)),
            'set {} to a URDF or xacro file'.format(option))
    if path.endswith(_XACRO):
        return _expanded(path, content, arguments)
    try:
        root = parse_xml(text)
    except MarkupError:
        return text     # who reads it says what is wrong with it
    try:
        check_expanded(root)
    except MarkupError as error:
        raise UserError('cannot use the robot in {}: {}'.format(path, error.problem), error.advice)
    return text


def read_any(path: str) -> Union[str, bytes]:
    """Return the content of a file, or what it expands to if its name ends with .xacro.

    Raises OSError and MarkupError as `read_bytes` does, and UserError as `read` does.
    """
    content = read_bytes(path)
    return _expanded(path, content) if path.endswith(_XACRO) else content


def xacro_command() -> int:
    """Run the xacro of pip, with ROS 1's packages, on the program's arguments; return 0."""
    import xacro
    with _package_index([]):
        xacro.main()
    return 0


def _text(content: bytes) -> str:
    """Return what is UTF-8, or else Latin-1; MarkupError for what is no text."""
    if b'\0' in content:
        raise MarkupError('it is not a text file')
    try:
        return content.decode()
    except UnicodeDecodeError:
        return content.decode('latin-1')


def _divided(text: str) -> Tuple[str, List[str]]:
    """Return a path and the arguments of xacro after it, as NAME:=VALUE.

    >>> _divided('my robot.urdf.xacro arm:=true size=2')
    ('my robot.urdf.xacro', ['arm:=true', 'size:=2'])
    """
    found = re.fullmatch(r'(.*?)((?:\s+[A-Za-z_]\w*:?=\S*)*)\s*', text, re.DOTALL)
    if found is None or os.path.exists(text):
        return text, []
    return found.group(1), [re.sub('^([^:=]*):?=', r'\1:=', word)
                            for word in found.group(2).split()]


def _expanded(path: str, content: bytes, arguments: Sequence[str] = ()) -> str:
    try:
        check_xml(content)
    except MarkupError as error:
        raise _failed(path, error)
    command = _ros_command()
    if command is not None:
        return _expanded_by_command(command, path, arguments)
    try:
        # the xacro of ROS 2, which PyPI has; that of ROS 1 has no such module
        import xacro.substitution_args      # noqa: F401
    except ImportError as error:
        raise UserError(
            'cannot use {}: it is a xacro file, and xacro cannot be loaded: {}'.format(
                path, one_line(error)),
            'install it (Ubuntu 20.04: apt-get install ros-noetic-xacro, Debian: {} -m pip '
            'install xacro) or convert the file elsewhere: xacro {} > robot.urdf'.format(
                *map(shlex.quote, (sys.executable, path))))
    return _expanded_by_module(path, arguments)


def _ros_command() -> Optional[str]:
    """Return the path of ROS 1's command xacro, None when that package is not installed."""
    try:
        if _is_our_package(rospkg.RosPack().get_path('xacro')):
            return None
    except rospkg.ResourceNotFound:
        return None
    folders = [folder for folder in os.environ.get('PATH', os.defpath).split(os.pathsep)
               if not _is_our_package(os.path.join(folder, os.pardir, 'share', 'xacro'))]
    if sys.prefix != sys.base_prefix:
        # a virtual environment may have ROS 2's
        folders = [folder for folder in folders if folder != os.path.join(sys.prefix, 'bin')]
    return shutil.which('xacro', path=os.pathsep.join(folders))


def _is_our_package(folder: str) -> bool:
    """Return whether a folder is the package xacro of our devel space, which runs pip's."""
    try:
        with open(os.path.join(folder, 'package.xml')) as file:
            return '<exec_depend>img_recog<' in file.read()
    except OSError:
        return False


def _expanded_by_command(command: str, path: str, arguments: Sequence[str]) -> str:
    try:
        result = subprocess.run([command, path, *arguments], stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                timeout=_TIMEOUT_S, check=True, universal_newlines=True)
    except subprocess.CalledProcessError as error:
        raise _failed(path, UserError(error.stderr.strip()))
    except (OSError, subprocess.TimeoutExpired) as error:
        raise _failed(path, error)
    return result.stdout


def _expanded_by_module(path: str, arguments: Sequence[str]) -> str:
    import xacro
    missing: List[str] = []
    del xacro.all_includes[:]       # it keeps those of files before
    setattr(xacro, 'open', lambda path: open(path, opener=plain))       # what it includes
    try:
        with _package_index(missing):
            return xacro.process_file(path, mappings=dict(
                each.split(':=', 1) for each in arguments)).toxml()
    except Exception as error:      # xacro evaluates Python expressions: anything may be raised
        if missing:
            files = [path, *filter(os.path.isfile, xacro.all_includes)]
            missing += [name for file in files for name in _packages_in(file)]
            raise UserError(
                'xacro cannot expand {}: there is no ROS package {}'.format(
                    path, ', '.join(dict.fromkeys(missing))),
                'source the workspace that has it, or add its folder to ROS_PACKAGE_PATH')
        where = io.StringIO()
        with contextlib.redirect_stderr(where):     # as its command does: the macro and the files
            xacro.print_location()
        raise _failed(path, UserError(one_line(error),
                                      ', '.join(where.getvalue().splitlines())))


def _packages_in(path: str) -> List[str]:
    """Return the names of the packages that a xacro file wants to find and that are not there."""
    text = re.sub('<!--.*?-->', '', read_bytes(path).decode('utf-8', 'replace'), flags=re.DOTALL)
    there = rospkg.RosPack().list()
    return [name for name in re.findall(r'\$\(find +([^)\s$]+) *\)', text) if name not in there]


@contextlib.contextmanager
def _package_index(missing: List[str]) -> Iterator[None]:
    """Let xacro find ROS 1 packages for $(find ...).

    It asks ament_index_python, the package index of ROS 2, which it imports when it needs it.
    missing: gets the names of packages that are not found.
    """
    packages_of_ros = rospkg.RosPack()

    def path_of(package: str) -> str:
        try:
            return packages_of_ros.get_path(package)
        except rospkg.ResourceNotFound:
            missing.append(package)
            raise

    index = types.ModuleType('ament_index_python')
    packages = types.ModuleType('ament_index_python.packages')
    setattr(packages, 'get_package_share_directory', path_of)
    ours = {module.__name__: module for module in (index, packages)}
    replaced = {name: sys.modules[name] for name in ours if name in sys.modules}
    sys.modules.update(ours)
    try:
        yield
    finally:
        for name in ours:
            del sys.modules[name]
        sys.modules.update(replaced)


def _failed(path: str, reason: object) -> UserError:
    return UserError('xacro cannot expand {}: {}'.format(path, one_line(reason)))
