"""No folder of the package has a forbidden import; planted violations are found."""
import pathlib
import shutil

import pytest
from setuptools import find_packages

from img_recog_helpers.walls import circles, violations

SOURCES = pathlib.Path(__file__).resolve().parents[2] / 'src'


def test_the_package_has_no_forbidden_imports():
    assert violations(SOURCES / 'img_recog') == []


def test_no_file_and_no_folder_imports_itself_through_others():
    assert circles(SOURCES / 'img_recog') == []


def test_planted_circles_are_found(tmp_path):
    for path, text in (('ros/a/one.py', 'from img_recog.ros.b import two'),
                       ('ros/b/two.py', 'x = 1'),
                       ('ros/b/three.py', 'def f():\n    from img_recog.ros.a.four import y'),
                       ('ros/a/four.py', 'y = 1'),
                       ('camera/five.py', 'import img_recog.camera.six'),
                       ('camera/six.py', 'from . import five')):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text + '\n')
    assert circles(tmp_path) == ['camera/five.py camera/six.py', 'camera/five.py camera/six.py',
                                 'ros/a ros/b']


def test_only_lifecycle_uses_shutdown_hooks_of_rospy():
    users = [path.name for path in (SOURCES / 'img_recog').rglob('*.py')
             if 'rospy.on_shutdown(' in path.read_text()]
    assert users == ['lifecycle.py']        # its on_shutdown explains why


@pytest.mark.parametrize('path, line, words', [
    ('camera/deeper/a.py', 'import rospy', 'camera runs without a node'),
    ('recognition/deeper/a.py', 'from img_recog.camera import source', 'recognition may use'),
    ('simulation/deeper/a.py', 'from img_recog import rendering', 'simulation may use'),
    ('rendering/a.py', 'from img_recog.simulation.physics.body import Body', 'rendering may use'),
    ('rendering/a.py', 'import pybullet', 'may use pybullet'),
    ('formats/a.py', 'import pybullet', 'may use pybullet'),
    ('simulation/a.py', 'import pybullet', 'may use pybullet'),
    ('formats/a.py', 'from img_recog.simulation.physics import body', 'formats may use'),
    ('formats/a.py', 'from img_recog.camera import source', 'formats may use'),
    ('simulation/physics/a.py', 'from img_recog.simulation.sensors import imu',
     'sensors is above physics'),
    ('simulation/sensors/a.py', 'from img_recog.simulation.simulated_model import Robot',
     'simulated_model is above sensors'),
    ('simulation/simulator.py', 'from .pictures import view', 'pictures is above simulator'),
    ('simulation/deeper/a.py', 'from img_recog.simulation.physics import body',
     'deeper is not a room'),
    ('teleoperation.py', 'from geometry_msgs.msg import Twist',
     'teleoperation must not use ROS'),
    ('camera/deeper/a.py', 'def f():\n    import rosgraph', 'camera must not use ROS'),
    ('camera/a.py', 'import importlib\nimportlib.import_module("genpy")',
     'camera must not use ROS'),
    ('simulation/a.py', 'from std_srvs.srv import Empty', 'simulation must not use ROS'),
    ('simulation/deeper/a.py', 'from ...ros import queues', 'simulation may use'),
    ('simulation/physics/a.py', 'import trimesh', 'only formats/meshes may use trimesh'),
    ('nodes/gazebo/a.py', 'import moderngl', 'only rendering may use moderngl'),
    ('nodes/gazebo/a.py', 'from nicegui import ui', 'only nodes/web may use nicegui'),
    ('ros/a.py', 'import uvicorn', 'only nodes/web may use uvicorn'),
    ('nodes/gazebo/a.py', 'from img_recog.nodes.usb_cam import usb_cam_node',
     'a node does not import'),
    ('nodes/gazebo/a.py', 'from ..usb_cam.usb_cam_node import UsbCam', 'a node does not import'),
    ('nodes/usb_cam/deeper/a.py', 'from img_recog.replay import chain', 'nodes may use'),
    ('nodes/usb_cam/a.py', 'import pybullet as p', 'may use pybullet'),
    ('replay/deeper/a.py', 'from rospy import Time', 'replay runs without a node'),
    ('replay/a.py', 'from img_recog.nodes import compressed_images', 'replay may use'),
    ('replay/a.py', 'from img_recog.ros.queues import LatestValue', 'replay may use'),
    ('replay/a.py', 'from dask import delayed', 'only batch may use dask'),
    ('nodes/web/a.py', 'from distributed import Client', 'only batch may use distributed'),
    ('recordings/a.py', 'import rospy', 'recordings runs without a node'),
    ('recordings/a.py', 'from img_recog.replay import chain', 'recordings may use'),
    ('nodes/usb_cam/a.py', 'from img_recog.recordings import parts', 'nodes may use'),
    ('batch/a.py', 'import rospy', 'batch runs without a node'),
    ('batch/a.py', 'from img_recog.nodes import compressed_images', 'batch may use'),
    ('replay/a.py', 'from img_recog.batch import engine', 'replay may use'),
    ('testing/a.py', 'from img_recog.nodes.gazebo import gazebo_node', 'testing may use'),
    ('nodes/gazebo/a.py', 'from img_recog.testing import Simulation', 'nodes may use'),
    ('graph/a.py', 'import rospy', 'graph runs without a node'),
    ('conversions/a.py', 'import rospy.rostime', 'conversions runs without a node'),
    ('conversions/a.py', 'from img_recog.ros import queues', 'conversions may use'),
    ('ros/deeper/a.py', 'from img_recog.simulation.physics import body', 'ros may use'),
    ('ros/a.py', 'from img_recog.conversions import image_msgs', 'ros may use'),
    ('ros/a.py', 'from rospy.impl import tcpros', 'internals of rospy'),
    ('ros/a.py', 'import rospy.impl.registration', 'internals of rospy'),
    ('nodes/usb_cam/a.py', 'import rospy\nrospy.rostime._set_rostime(0)', 'internals of rospy'),
    ('nodes/usb_cam/a.py', 'from rospy.core import _shutdown_lock', 'internals of rospy'),
    ('nodes/gazebo/deeper/a.py', 'publisher.impl.connections', 'internals of rospy'),
    ('nodes/teleop_key.py', 'from img_recog.nodes.usb_cam import usb_cam_node',
     'a node does not import'),
    ('nodes/usb_cam/a.py', 'import rospy as r\nr.rostime._x', 'internals of rospy'),
    ('ros/a.py', 'from rospy import rostime as t\nt._x', 'internals of rospy'),
    ('ros/a.py', 'from rospy import *', 'internals of rospy'),
    ('nodes/usb_cam/a.py', 'msg._connection_header', 'internals of rospy'),
    ('nodes/usb_cam/a.py', 'from img_recog.ros.transport import outbox', 'outbox is for'),
    ('graph/a.py', 'from img_recog.ros import parameters', 'may use only timed_xmlrpc'),
    ('__init__.py', 'import rosgraph', '__init__ must not use ROS'),
    ('__init__.py', 'from img_recog.ros import queues', '__init__ may use nothing'),
    ('helpers/a.py', 'import math', 'helpers is not a part'),
    ('loading/a.py', 'import rospy', 'loading runs without a node'),
    ('loading/a.py', 'from img_recog.ros import parameters', 'loading may use'),
    ('formats/a.py', 'from img_recog.loading import resources', 'formats may use'),
    ('formats/a.py', 'import rospkg', 'formats must not use ROS'),
    ('files.py', 'import rospkg', 'files must not use ROS'),
    ('files.py', 'from img_recog.camera import source', 'files may use'),
    ('settings.py', 'from img_recog import files', 'settings may use')])
def test_a_planted_violation_is_found(tmp_path, path, line, words):
    planted = tmp_path / path
    planted.parent.mkdir(parents=True, exist_ok=True)
    planted.write_text(line + '\n')
    found, = violations(tmp_path)
    assert found.startswith('{}:'.format(path)) and words in found


@pytest.mark.parametrize('path, line', [
    ('ros/transport/a.py', 'from rospy.impl import tcpros\nx.impl.connections'),
    ('ros/a.py', 'import rospy\nrospy.core.is_shutdown_requested()'),
    ('replay/a.py', 'import rosbag, genpy\nfrom img_recog.simulation import body'),
    ('nodes/gazebo/a.py', 'from img_recog.nodes import compressed_images\nfrom . import clock'),
    ('nodes/web/a.py', 'from nicegui import ui\nfrom img_recog.graph import dot'),
    ('formats/meshes/a.py', 'import trimesh, collada'),
    ('camera/a.py', 'from img_recog.formats import markup, still_images'),
    ('batch/a.py', 'import distributed\nfrom img_recog.replay import job'),
    ('simulation/sensors/a.py', 'import pybullet\nfrom img_recog.simulation.physics import body')])
def test_allowed_imports_are_not_reported(tmp_path, path, line):
    planted = tmp_path / path
    planted.parent.mkdir(parents=True, exist_ok=True)
    planted.write_text(line + '\n')
    assert violations(tmp_path) == []


def test_every_folder_is_an_installed_package(tmp_path):
    folders = {path.parent for path in (SOURCES / 'img_recog').rglob('*.py')}
    names = {'.'.join(folder.relative_to(SOURCES).parts) for folder in folders}
    assert set(find_packages(str(SOURCES))) == names
    # setup.py calls find_packages, which silently skips a folder without __init__.py
    shutil.copytree(str(SOURCES / 'img_recog' / 'ros'), str(tmp_path / 'ros'))
    (tmp_path / 'ros' / 'transport' / '__init__.py').unlink()
    assert set(find_packages(str(tmp_path))) == {'ros'}
