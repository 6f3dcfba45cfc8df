"""Runs of worlds in Gazebo, and the comparison of poses, for compare_cases.py and
compare_robots.py.

Gazebo is a program that the user names. It takes the same arguments as simulate.py and prints the
same lines of JSON.
"""
import json
import math
import os
import re
import subprocess
from typing import Any, Dict, List, Sequence, Tuple

from img_recog.errors import UserError

_PORT_OPTION = '--port'
_POSE_NUMBERS = 7       # position and quaternion
_JSON_NUMBERS = {'nan': 'NaN', '-nan': 'NaN', 'inf': 'Infinity', '-inf': '-Infinity'}
_NOT_FINITE = re.compile(r'(?<=[\[,: ])-?(?:nan|inf)(?=[,\]} ])')


class GazeboProgram:
    """A program that runs a world in Gazebo."""

    def __init__(self, path: str, port: str = ''):
        """Set the program.

        Args:
            path: Path of the program.
            port: Port of Gazebo's master; empty for the default of the program.
        """
        self._path = path
        self._options = [_PORT_OPTION, port] if port else []

    def run(self, world: str, until_s: float, every_s: float, drives: Sequence[str] = (),
            velocities: Sequence[str] = ()) -> List[Dict[str, Any]]:
        """Run a world and return the lines that Gazebo printed.

        Args:
            world: Path of an SDF file.
            until_s: Simulated time at the end, in s.
            every_s: Simulated time between two lines, in s.
            drives: Motors, each as MODEL::JOINT=VELOCITY:TORQUE.
            velocities: Velocities of models at the start, each as MODEL=VX,VY,VZ[,WX,WY,WZ].

        Raises:
            UserError: if the program fails or prints no state.
        """
        command = [self._path, world, '--until', repr(until_s), '--every', repr(every_s),
                   *self._options]
        command += [word for drive in drives for word in ('--drive', drive)]
        command += [word for velocity in velocities for word in ('--velocity', velocity)]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             universal_newlines=True)
        try:
            lines = [parse_line(line) for line in run.stdout.splitlines() if line]
        except ValueError:
            lines = []
        if not any('links' in line for line in lines):
            reason = run.stderr.strip().splitlines()[-1:] or ['it printed no state']
            raise UserError('Gazebo cannot run {}: {}'.format(world, reason[0]),
                            'run it with --log to see what Gazebo reports')
        return lines


def parse_line(text: str) -> Dict[str, Any]:
    """Return a line of JSON in which numbers may be nan or inf, as C++ prints them.

    >>> parse_line('{"joints": {"inf_nan": [-nan, inf]}}')
    {'joints': {'inf_nan': [nan, inf]}}
    """
    return json.loads(_NOT_FINITE.sub(lambda found: _JSON_NUMBERS[found.group()], text))


class StoredResults:
    """Results in a JSON file, by name."""

    def __init__(self, path: str):
        """Read the file if it exists.

        Args:
            path: Path of the file.
        """
        self._path = path
        self.by_name: Dict[str, Any] = {}
        if os.path.exists(path):
            with open(path) as file:
                self.by_name = json.load(file)

    def store(self, name: str, result: Any) -> None:
        """Store a result and write the file.

        Args:
            name: Name of the result.
            result: Anything that JSON can represent.
        """
        self.by_name[name] = result
        write_json(self._path, self.by_name)


def write_json(path: str, value: Any) -> None:
    """Write a value with the last digit of each number, one entry of the outer mapping a line.

    Args:
        path: Path of the file; a file there is replaced when the new one is complete.
        value: A mapping of names to anything that JSON can represent.
    """
    temporary = path + '.new'
    with open(temporary, 'w') as file:
        file.write('{\n' + ',\n'.join('{}: {}'.format(
            json.dumps(name), json.dumps(value[name])) for name in sorted(value)) + '\n}\n')
    os.replace(temporary, path)


def final_state(lines: Sequence[Dict[str, Any]]) -> Dict[str, Any]:
    """Return the last poses of links, the last states of joints, and the rays.

    Args:
        lines: Lines of simulate.py or of the program that runs Gazebo.

    >>> final_state([{'t': 0, 'links': {'a::b': [0] * 13}, 'joints': {}},
    ...              {'t': 1, 'links': {'a::b': [1] * 13}, 'joints': {}},
    ...              {'ray': 'scan', 'ranges': [1.5]}, {'end': True}])
    {'t': 1, 'links': {'a::b': [1, 1, 1, 1, 1, 1, 1]}, 'joints': {}, 'rays': {'scan': [1.5]}}
    """
    state = [line for line in lines if 'links' in line][-1]
    rays = {line[kind]: line['ranges'] for line in lines for kind in ('ray', 'gpuray')
            if kind in line}
    return {'t': state['t'],
            'links': {name: values[:_POSE_NUMBERS] for name, values in state['links'].items()},
            'joints': state['joints'], 'rays': rays}


def pose_difference(pose_a: Sequence[float], pose_b: Sequence[float]) -> Tuple[float, float]:
    """Return the distance in m and the angle in rad between two poses.

    Args:
        pose_a: x, y, z in m and a quaternion x, y, z, w.
        pose_b: The other pose.

    >>> pose_difference([0, 0, 0, 0, 0, 0, 1], [3, 4, 0, 0, 0, 1, 0])
    (5.0, 3.141592653589793)
    """
    distance = math.sqrt(sum((a - b) ** 2 for a, b in zip(pose_a[:3], pose_b[:3])))
    a, b = pose_a[3:7], pose_b[3:7]
    # the half angle from its sine and cosine: the cosine alone has no digits for small angles
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    sines = (aw * bx - ax * bw - ay * bz + az * by, aw * by + ax * bz - ay * bw - az * bx,
             aw * bz - ax * by + ay * bx - az * bw)
    cosine = sum(first * second for first, second in zip(a, b))
    return distance, 2 * math.atan2(math.sqrt(sum(each ** 2 for each in sines)), abs(cosine))
