"""Public robots, from a list and clones of their repositories, in Gazebo and in our simulator.

compare_robots.py has the command line. A clone is in OWNER+NAME of the folder of clones.
"""
import math
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence, Tuple

import yaml

from gazebo_runs import GazeboProgram
from img_recog import rotations
from img_recog.errors import UserError
from img_recog.formats.world_file import EMPTY
from img_recog.loading import assemble, resources, robot_file
from img_recog.simulation.models import LINK_SEPARATOR, Figures
from img_recog.simulation.physics.drive import Drive
from img_recog.simulation.simulation_settings import (DriveSettings, PhysicsSettings,
                                                      SpawnSettings)
from img_recog.simulation.simulator import Simulator

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..')
LIST = os.path.join(ROOT, 'test', 'public_robots.yaml')
COMMANDS = {'straight': (0.2, 0.0), 'turn': (0.0, 0.5), 'both': (0.2, 0.5)}     # m/s, rad/s
HEADINGS = (0.0, 0.02, 0.3, 0.785)      # rad
UNTIL_S = 3.0
_EVERY_S = 0.1
_WORLDS = 'worlds'
_EMPTY_FILES = '.empty_files'
_EMPTY_XACRO = '<robot xmlns:xacro="http://ros.org/wiki/xacro"/>\n'
_PACKAGE_XML = '<package format="2"><name>{}</name></package>\n'
_CONVERTED_VERSION = '1.7'      # in which Gazebo 11 writes what it makes of a URDF
_GROUND = '<include><uri>model://ground_plane</uri></include>'
_DECIMALS = 4


class Robot(NamedTuple):
    """A robot of the list.

    Attributes:
        name: Name in the list.
        repository: OWNER/NAME at GitHub.
        commit: Commit of the repository.
        file: Path of a URDF, xacro or SDF file in the repository.
        left: Joints of the left wheels.
        right: Joints of the right wheels.
        diameter: Diameter of the wheels in m.
        separation: Distance between the left and the right wheels in m.
        torque: Maximum torque of a wheel in N m.
        height: Height of the root link at the start in m.
        reversed: Joints whose wheels roll backward at a positive velocity.
        arguments: Arguments of xacro.
        empty_files: PACKAGE/PATH of included files of other repositories, which are not needed.
    """

    name: str
    repository: str
    commit: str
    file: str
    left: Sequence[str]
    right: Sequence[str]
    diameter: float
    separation: float
    torque: float
    height: float
    reversed: Sequence[str] = ()
    arguments: str = ''
    empty_files: Sequence[str] = ()

    @property
    def clone(self) -> str:
        """Name of the folder with its repository."""
        return self.repository.replace('/', '+')

    @property
    def is_sdf(self) -> bool:
        """Whether its file is an SDF."""
        return self.file.endswith('.sdf')

    def wheel_velocities(self, command: str) -> Tuple[float, float]:
        """Return the velocities of the left and right joints in rad/s.

        Args:
            command: A name of COMMANDS.

        >>> robot = Robot('a', 'b/c', '', 'd.urdf', ['l'], ['r'], 0.2, 0.4, 5.0, 0.0)
        >>> robot.wheel_velocities('straight'), robot.wheel_velocities('turn')
        ((2.0, 2.0), (-1.0, 1.0))
        """
        linear, angular = COMMANDS[command]
        difference = angular * self.separation / 2
        radius = self.diameter / 2
        return (linear - difference) / radius, (linear + difference) / radius

    def motors(self, command: str) -> Iterator[Tuple[str, float]]:
        """Yield the joints of the wheels with their velocities in rad/s.

        Args:
            command: A name of COMMANDS.
        """
        left, right = self.wheel_velocities(command)
        for joints, velocity in ((self.left, left), (self.right, right)):
            yield from ((joint, -velocity if joint in self.reversed else velocity)
                        for joint in joints)


def read_list(names: Sequence[str] = (), path: str = LIST) -> List[Robot]:
    """Return the robots of the list.

    Args:
        names: Names of robots; none for all.
        path: Path of the list.

    Raises:
        UserError: if there is no such robot.
    """
    with open(path) as file:
        robots = {name: Robot(name, **values) for name, values in yaml.safe_load(file).items()}
    unknown = sorted(set(names) - set(robots))
    if unknown:
        raise UserError('there is no robot {} in {}'.format(', '.join(unknown), path),
                        'the list has: ' + ', '.join(robots))
    return [robots[name] for name in names or robots]


def environment(robot: Robot, folder: str) -> Dict[str, str]:
    """Return environment variables with which the packages of a robot are found.

    Two repositories can have packages with the same name, so each robot needs its own process.

    Args:
        robot: The robot.
        folder: Folder of clones.
    """
    clone = os.path.join(folder, robot.clone)
    packages = [clone]
    if robot.empty_files:
        packages.append(_write_empty_files(robot, folder))
    models = [clone, os.path.dirname(os.path.dirname(os.path.join(clone, robot.file)))]
    return {**os.environ, 'ROS_PACKAGE_PATH': os.pathsep.join([*packages, os.path.abspath(ROOT)]),
            'GAZEBO_MODEL_PATH': os.pathsep.join(models), 'GAZEBO_RESOURCE_PATH': ''}


def _write_empty_files(robot: Robot, folder: str) -> str:
    top = os.path.join(folder, _EMPTY_FILES, robot.name)
    for each in robot.empty_files:
        package = each.split('/')[0]
        path = os.path.join(top, each)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        for name, text in ((path, _EMPTY_XACRO), (os.path.join(
                top, package, 'package.xml'), _PACKAGE_XML.format(package))):
            with open(name, 'w') as file:
                file.write(text)
    return top


def read_robot(robot: Robot, folder: str) -> ElementTree.Element:
    """Return the <robot> of a URDF or the <model> of an SDF, without shapes that are missing.

    Args:
        robot: The robot.
        folder: Folder of clones.

    Raises:
        UserError: if the file cannot be read.
    """
    path = os.path.join(folder, robot.clone, robot.file)
    text = robot_file.read_any(path) if robot.is_sdf else robot_file.read(
        ' '.join([path, robot.arguments]).strip())
    root = ElementTree.fromstring(text)
    if robot.is_sdf:
        root = next(root.iter('model'))
    for link in root.iter('link'):
        for kind in ('collision', 'visual'):
            for shape in link.findall(kind):
                if any(resources.find(uri) is None for uri in _mesh_uris(shape)):
                    sys.stderr.write('{}: left out, without its mesh: {} of link {}\n'.format(
                        robot.name, kind, link.get('name')))
                    link.remove(shape)
    return root


def _mesh_uris(element: ElementTree.Element) -> Iterator[str]:
    yield from (mesh.get('filename', '') for mesh in element.iter('mesh') if mesh.get('filename'))
    yield from ((mesh.findtext('uri') or '').strip() for mesh in element.iter('mesh')
                if mesh.find('uri') is not None)


def write_worlds(robot: Robot, folder: str, convert: str) -> str:
    """Write a world of Gazebo for each command and heading.

    Several robots in one world would be faster. But robots with wheels of meshes then move
    differently: the scout mini drives half as far.

    Args:
        robot: The robot.
        folder: Folder of clones; the worlds are in worlds/NAME there, with their meshes.
        convert: Command that reads a URDF and prints the SDF that Gazebo makes of it.

    Returns:
        Path of the folder of the worlds.
    """
    model, version = read_robot(robot, folder), _CONVERTED_VERSION
    if robot.is_sdf:
        version = _version(os.path.join(folder, robot.clone, robot.file))
    else:
        run = subprocess.run(convert, shell=True, input=ElementTree.tostring(model),
                             stdout=subprocess.PIPE, check=True)
        model = next(ElementTree.fromstring(run.stdout).iter('model'))
    place = os.path.join(folder, _WORLDS, robot.name)
    shutil.rmtree(place, ignore_errors=True)
    os.makedirs(place)
    _remove(model, ('plugin', 'sensor', 'visual'))
    for number, mesh in enumerate(model.iter('mesh')):
        uri = mesh.find('uri')
        if uri is not None:
            uri.text = 'file://' + _copied_mesh((uri.text or '').strip(), place, number)
    model.set('name', robot.name)
    for name, _, heading in starts():
        _place(model, robot.height, heading)
        _write_world(os.path.join(place, name + '.sdf'), model, version)
    return place


def _copied_mesh(uri: str, place: str, number: int) -> str:
    # sdformat writes package:// as model://
    found = resources.find(uri) or resources.find(uri.replace('model://', 'package://'))
    if found is None:
        raise UserError('there is no mesh {}'.format(uri))
    name = '{}_{}'.format(number, os.path.basename(found))
    shutil.copy(found, os.path.join(place, name))
    return name


def starts() -> Iterator[Tuple[str, str, float]]:
    """Yield the name of each world, its command and its heading."""
    yield from (('{}_{:g}'.format(command, heading), command, heading)
                for command in COMMANDS for heading in HEADINGS)


def _remove(root: ElementTree.Element, tags: Sequence[str]) -> None:
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in tags:
                parent.remove(child)


def _place(model: ElementTree.Element, z: float, heading: float) -> None:
    pose = model.find('pose')
    if pose is None:
        pose = ElementTree.Element('pose')
        model.insert(0, pose)
    pose.text = '0 0 {} 0 0 {}'.format(z, heading)


def _version(path: str) -> str:
    """Return the version of an SDF. An element can mean something else in another version."""
    return ElementTree.fromstring(robot_file.read_any(path)).get('version', '')


def _write_world(path: str, model: ElementTree.Element, version: str) -> None:
    with open(path, 'w') as file:
        file.write('<sdf version="{}">\n<world name="default">{}{}</world>\n</sdf>\n'.format(
            version, _GROUND, ElementTree.tostring(model, 'unicode')))


def run_in_gazebo(robot: Robot, worlds: str, program: GazeboProgram) -> Dict[str, Any]:
    """Run the worlds of `write_worlds` in Gazebo and return the values.

    Args:
        robot: The robot.
        worlds: Path of the folder of the worlds.
        program: The program that runs Gazebo.

    Returns:
        By command, for each heading: distance in m and yaw in rad.
    """
    results: Dict[str, Any] = {command: [] for command in COMMANDS}
    for name, command, _ in starts():
        drives = ['{}{}{}={!r}:{!r}'.format(robot.name, LINK_SEPARATOR, joint, velocity,
                                            robot.torque)
                  for joint, velocity in robot.motors(command)]
        lines = [line['links'] for line in program.run(
            os.path.join(worlds, name + '.sdf'), UNTIL_S, _EVERY_S, drives) if 'links' in line]
        root = next(link for link in lines[0] if link.startswith(robot.name + LINK_SEPARATOR))
        results[command].append(motion([line[root] for line in lines]))
    return results


def simulate(robot: Robot, folder: str, commands: Sequence[str]) -> Dict[str, Any]:
    """Run the robot in our simulator; arguments and result as for `run_in_gazebo`.

    Args:
        robot: The robot.
        folder: Folder of clones.
        commands: Names of COMMANDS.
    """
    element = read_robot(robot, folder)
    source = os.path.join(folder, robot.clone, robot.file)
    results: Dict[str, Any] = {command: [] for command in commands}
    for command in commands:
        for heading in HEADINGS:
            simulator = (_sdf_robot if robot.is_sdf else _urdf_robot)(
                robot, element, source, heading)
            results[command].append(motion(list(_poses(robot, simulator, command))))
            simulator.close()
    return results


def _urdf_robot(robot: Robot, element: ElementTree.Element, source: str,
                heading: float) -> Simulator:
    spec = assemble.robot_of(ElementTree.tostring(element, 'unicode'), source)
    drive = DriveSettings(
        left_joint=','.join(robot.left), right_joint=','.join(robot.right),
        wheel_diameter=robot.diameter, wheel_separation=robot.separation,
        wheel_torque=robot.torque)
    spawn = SpawnSettings(x_pos=0.0, y_pos=0.0, z_pos=robot.height, yaw=heading)
    return assemble.simulator(
        PhysicsSettings(world=EMPTY),
        [spec.changed(drive=drive, spawn=spawn)._replace(sensors=())])


def _sdf_robot(robot: Robot, element: ElementTree.Element, source: str,
               heading: float) -> Simulator:
    _remove(element, ('sensor',))
    _place(element, robot.height, heading)
    path = '{}.{}.sdf'.format(source, os.getpid())      # next to its meshes
    try:
        _write_world(path, element, _version(source))
        return assemble.simulator(PhysicsSettings(world=path), with_drives=True)
    finally:
        os.remove(path)


def _poses(robot: Robot, simulator: Simulator, command: str) -> Iterator[List[float]]:
    for simulated in simulator.robots:
        # as in Gazebo, nothing else sets the motors
        simulated.drive = Drive(DriveSettings())
    values = Figures(simulator)
    ends = {joint.rsplit(LINK_SEPARATOR, 1)[-1]: joint for joint in values.joints()}
    for joint, velocity in robot.motors(command):
        values.set_motor(ends.get(joint, joint), velocity, robot.torque)
    root = next(link for link in values.links() if not link.startswith('ground_plane'))
    steps = round(_EVERY_S / simulator.world.step_s)
    yield values.links()[root]
    for _ in range(round(UNTIL_S / _EVERY_S)):
        simulator.advance(steps)
        yield values.links()[root]


def motion(poses: Sequence[Sequence[float]]) -> Tuple[float, float]:
    """Return the distance in the plane, in m, and the yaw, in rad, between two poses of a link.

    Args:
        poses: Poses of the link, each x, y, z and a quaternion x, y, z, w, less than half a turn
            apart.

    >>> motion([(1, 1, 0, 0, 0, 0, 1), (4, 5, 0, 0, 0, 1, 1), (1, 5, 0, 0, 0, 1, 0),
    ...          (1, 1, 0, 0, 0, -1, 1)])
    (0.0, 4.7124)
    """
    distance = math.hypot(poses[-1][0] - poses[0][0], poses[-1][1] - poses[0][1])
    yaws = [rotations.yaw((pose[3], pose[4], pose[5], pose[6])) for pose in poses]
    turned = sum(math.remainder(after - before, 2 * math.pi)
                 for before, after in zip(yaws, yaws[1:]))
    return round(distance, _DECIMALS), round(turned, _DECIMALS)
