"""Draw the burger's drive in turtlebot3_world; print CPU and wall time of an image as JSON.

Arguments: METHOD VIEWPOINT WIDTH HEIGHT. When the scene is loaded, a line is printed; then one
for each line on the standard input, which is the number of seconds to draw.
"""
import importlib.util
import itertools
import json
import sys
import time
from typing import Callable, NamedTuple, Sequence

import numpy as np
import pybullet

from img_recog.loading import resources
from img_recog.model import SUN, VisualScene
from img_recog.rendering import matrices
from img_recog.rendering.camera import Camera
from img_recog.rendering.opengl import Renderer
from img_recog.replay import scenario
from img_recog.simulation.physics.body import Pose
from img_recog.simulation.physics.client import connect
from img_recog.simulation.pictures import view, visual_scene
from img_recog.simulation.pictures.scene import Scene, SceneCopy, poses_of
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors.robot_camera import RobotCamera
from img_recog.simulation.settings import CameraSettings, SpawnSettings

FRAMES, FRAME_STEPS = 60, 33        # 2 s at 30 Hz, in steps of 1 ms
SPEEDS = (0.1, 0.5)                 # m/s and rad/s, those of sample.py


class Moment(NamedTuple):
    """What an image shows: for PyBullet the poses of bodies, for img_recog of parts (n, 7)."""

    camera_pose: np.ndarray
    parts: np.ndarray
    bodies: Sequence[Pose]


class Drive(NamedTuple):
    """A drive that was simulated."""

    scene: Scene
    visuals: VisualScene
    moments: Sequence[Moment]


def simulate(viewpoint: str) -> Drive:
    """Return a drive, seen by the robot's camera (viewpoint robot) or from above."""
    built = scenario.build(resources.DEFAULT_WORLD, resources.burger(), SpawnSettings())
    simulator, parts = built.simulator, Parts(built.simulator)
    vehicle = simulator.vehicles[0]
    camera = RobotCamera(vehicle.robot, CameraSettings(camera_frame='camera_link'), parts.poses)
    vehicle.command(*SPEEDS)
    visuals, moments = visual_scene.read(built.scene, parts), []
    for _ in range(FRAMES):
        simulator.advance(FRAME_STEPS)
        exposure = camera.read()
        pose = exposure.camera_pose if viewpoint == 'robot' else view.ABOVE.pose()
        moments.append(Moment(pose, exposure.poses, poses_of(simulator)))
    return Drive(built.scene, visuals, moments)


Draw = Callable[[Moment], np.ndarray]


def ours(drive: Drive, camera: Camera) -> Draw:
    """Return a function that draws by OpenGL, like the node."""
    renderer = Renderer()
    renderer.load(drive.visuals, drive.moments[0].parts)
    return lambda moment: renderer.draw(camera, moment.camera_pose, moment.parts)


def our_depths(drive: Drive, camera: Camera) -> Draw:
    """Return a function that draws depths by OpenGL, like the node."""
    renderer = Renderer()
    renderer.load(drive.visuals, drive.moments[0].parts)
    return lambda moment: renderer.depth(camera, moment.camera_pose, moment.parts)


def pybullet_by(client: int) -> Callable[[Drive, Camera], Draw]:
    """Return a method like `ours` that draws by PyBullet's OpenGL, with its light."""
    def load(drive: Drive, camera: Camera) -> Draw:
        scene = SceneCopy(drive.scene, client, floor=True)
        projection = matrices.perspective(camera.window, camera.near, camera.far)

        def draw(moment: Moment) -> np.ndarray:
            scene.place(moment.bodies)
            return pybullet.getCameraImage(
                camera.width, camera.height,
                matrices.view(moment.camera_pose).T.ravel().tolist(),
                projection.T.ravel().tolist(), shadow=1,
                lightDirection=[-axis for axis in SUN.direction], lightColor=(1, 1, 1),
                lightAmbientCoeff=0.75, lightDiffuseCoeff=0.25, lightSpecularCoeff=0.0,
                flags=pybullet.ER_NO_SEGMENTATION_MASK,
                renderer=pybullet.ER_BULLET_HARDWARE_OPENGL,
                physicsClientId=client)[2]
        return draw
    return load


def egl() -> Callable[[Drive, Camera], Draw]:
    """Return the method of PyBullet's EGL plugin, with shadows; ends the program without it."""
    client = connect()
    plugin = importlib.util.find_spec('eglRenderer')
    # where there is no EGL, the plugin ends the program itself, or is not loaded
    if plugin is None or plugin.origin is None or pybullet.loadPlugin(
            plugin.origin, '_eglRendererPlugin', physicsClientId=client) < 0:
        sys.exit(1)
    return pybullet_by(client)


METHODS = {'img_recog': lambda: ours, 'img_recog, depths': lambda: our_depths,
           "PyBullet's EGL plugin": egl}


def camera_of(viewpoint: str, width: int, height: int) -> Camera:
    """Return the camera of a viewpoint."""
    fov = (CameraSettings().camera_horizontal_fov if viewpoint == 'robot'
           else view.horizontal_fov(width, height))
    return Camera(width, height, fov)


def main() -> int:
    """Draw until the standard input ends."""
    method, viewpoint, width, height = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    load, drive = METHODS[method](), simulate(viewpoint)
    draw = load(drive, camera_of(viewpoint, width, height))
    moments = itertools.cycle(drive.moments)
    for _ in range(3):
        draw(next(moments))
    sys.stdout.write('ready\n')
    sys.stdout.flush()
    for line in sys.stdin:
        count, processor, begin = 0, time.process_time(), time.perf_counter()
        while time.perf_counter() - begin < float(line) or not count:
            draw(next(moments))
            count += 1
        wall = time.perf_counter() - begin
        sys.stdout.write(json.dumps({
            'cpu_ms': 1e3 * (time.process_time() - processor) / count,
            'wall_ms': 1e3 * wall / count, 'images': count}) + '\n')
        sys.stdout.flush()
    return 0


if __name__ == '__main__':
    sys.exit(main())
