"""Draw the burger's drive in turtlebot3_world; print CPU and wall time of an image as JSON.

Arguments: METHOD WIDTH HEIGHT.
"""
import functools
import importlib.util
import itertools
import sys
import time
from typing import Callable, Iterator, NamedTuple, Sequence

import numpy as np
import pybullet
from ros_processes import answer

from img_recog.loading import resources
from img_recog.model import SUN, VisualScene
from img_recog.rendering import matrices
from img_recog.rendering.camera import Camera
from img_recog.rendering.opengl import Renderer
from img_recog.replay import scenario
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.client import connect
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.pictures.window import Scene, SceneCopy, poses_of, scene_of
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.simulation_settings import CameraSettings, SpawnSettings

FRAMES, FRAME_STEPS = 60, 33        # 2 s at 30 Hz, in steps of 1 ms
SPEEDS = (0.1, 0.5)                 # m/s and rad/s, of drive_sample.py


class Moment(NamedTuple):
    """What an image shows: for PyBullet the poses of bodies, for img_recog of parts (n, 7)."""

    camera_pose: np.ndarray
    parts: np.ndarray
    bodies: Sequence[BodyPose]


class Drive(NamedTuple):
    """A drive that was simulated."""

    scene: Scene
    visuals: VisualScene
    moments: Sequence[Moment]


def simulate() -> Drive:
    """Return a drive, seen by the robot's camera."""
    simulator = scenario.build(resources.DEFAULT_WORLD, resources.burger(), SpawnSettings())
    parts, robot = Parts(simulator), simulator.robots[0]
    camera = RobotCamera(robot.body, CameraSettings(camera_frame='camera_link'), parts.poses)
    robot.command(*SPEEDS)
    visuals, moments = parts.scene(), []
    for _ in range(FRAMES):
        simulator.advance(FRAME_STEPS)
        exposure = camera.read()
        moments.append(Moment(exposure.camera_pose, exposure.poses, poses_of(simulator)))
    return Drive(scene_of(simulator), visuals, moments)


Draw = Callable[[Moment], np.ndarray]


def ours(drive: Drive, camera: Camera, depths: bool = False) -> Draw:
    """Return a function that draws by OpenGL, like the node: the image, or its depths."""
    renderer = Renderer()
    renderer.load(drive.visuals, drive.moments[0].parts)
    draw = renderer.depth if depths else renderer.draw
    return lambda moment: draw(camera, moment.camera_pose, moment.parts)


def egl(drive: Drive, camera: Camera) -> Draw:
    """Return that of PyBullet's EGL plugin, with its light and shadows; exits without one."""
    client = connect()
    plugin = importlib.util.find_spec('eglRenderer')
    # where there is no EGL, the plugin ends the program itself, or is not loaded
    if plugin is None or plugin.origin is None or pybullet.loadPlugin(
            plugin.origin, '_eglRendererPlugin', physicsClientId=client) < 0:
        sys.exit(1)
    scene = SceneCopy(drive.scene, client, floor=True)
    projection = matrices.perspective(camera.edges, camera.near, camera.far)

    def draw(moment: Moment) -> np.ndarray:
        scene.place(moment.bodies)
        return pybullet.getCameraImage(
            camera.width, camera.height, matrices.view(moment.camera_pose).T.ravel().tolist(),
            projection.T.ravel().tolist(), shadow=1,
            lightDirection=[-axis for axis in SUN.direction], lightColor=(1, 1, 1),
            lightAmbientCoeff=0.75, lightDiffuseCoeff=0.25, lightSpecularCoeff=0.0,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            renderer=pybullet.ER_BULLET_HARDWARE_OPENGL, physicsClientId=client)[2]
    return draw


METHODS = {'img_recog': ours, 'img_recog, depths': functools.partial(ours, depths=True),
           "PyBullet's EGL plugin": egl}


def cost(draw: Draw, moments: Iterator[Moment], seconds: float) -> dict:
    """Draw for so long; return CPU and wall time of an image."""
    count, processor, begin = 0, time.process_time(), time.perf_counter()
    while time.perf_counter() - begin < seconds or not count:
        draw(next(moments))
        count += 1
    return {'cpu_ms': 1e3 * (time.process_time() - processor) / count,
            'wall_ms': 1e3 * (time.perf_counter() - begin) / count}


def main() -> None:
    """Draw until the standard input ends."""
    drive, (width, height) = simulate(), map(int, sys.argv[2:])
    draw = METHODS[sys.argv[1]](drive, Camera(
        width, height, CameraSettings().camera_horizontal_fov))
    moments = itertools.cycle(drive.moments)
    for _ in range(3):
        draw(next(moments))
    answer(lambda seconds: cost(draw, moments, seconds))


if __name__ == '__main__':
    main()
