"""A window on the simulation, in a process of its own.

PyBullet ends the process when its window is closed or no display can be opened, and a window
slows the physics client that it belongs to. So the window shows a copy of the world, to which
the simulation sends poses; it may come and go without the simulation noticing.
"""
import dataclasses
import multiprocessing
import os
import select
import signal
import time
from typing import Dict, Optional

import pybullet

from img_recog.simulation.description import Description
from img_recog.simulation.drawing import one_colour_a_link
from img_recog.simulation.robot import Pose, Robot
from img_recog.simulation.settings import SimulatorSettings
from img_recog.simulation.world import add_floor, load_urdf, read_world

_PERIOD_S = 1 / 30
_PATIENCE_S = 2.0               # with a window that was told to close
_OPTIONS = ('--background_color_red=0.7 --background_color_green=0.7 '
            '--background_color_blue=0.7 --width=1024 --height=768')
# What Gazebo's user camera of turtlebot3_world sees, straight down from (0.8, 0, 12) with x
# upwards. Its view is 60 degrees wide, PyBullet's 60 degrees high: from 9 m that is the same.
_CAMERA = {'cameraDistance': 9.0, 'cameraYaw': -90.0, 'cameraPitch': -89.99,
           'cameraTargetPosition': (0.8, 0.0, 0.0)}


class Viewer:
    """The sending end of a window."""

    def __init__(self, description: Description, worlds: Dict[str, str],
                 settings: SimulatorSettings):
        """Open the window; the arguments are those of the Simulator that it shows."""
        # a forked child would share the simulation's descriptors and locks
        context = multiprocessing.get_context('spawn')
        receiver, self._sender = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_show, args=(receiver, description, worlds, settings),
            daemon=True)
        self._process.start()
        receiver.close()
        self._next_s = 0.0

    def show(self, pose: Pose) -> Optional[str]:
        """Send a pose, at most 30 a second; return why the window is gone, None while it is not.
        """
        now = time.monotonic()
        if now < self._next_s:
            return None
        self._next_s = now + _PERIOD_S
        try:
            # a window that is slow to open or stalls must not hold up the simulation
            if select.select([], [self._sender], [], 0)[1]:
                self._sender.send(pose)
        except OSError:
            self._end()
            return 'closed' if self._process.exitcode == 0 else 'it could not be opened or broke'
        return None

    def close(self) -> None:
        """Close the window."""
        self._sender.close()
        self._end()

    def _end(self) -> None:
        self._process.join(_PATIENCE_S)
        if self._process.is_alive():
            self._process.terminate()
            self._process.join()


def _show(receiver, description: Description, worlds: Dict[str, str],
          settings: SimulatorSettings) -> None:
    # Ctrl-C reaches the whole process group; the window goes when the simulation does
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # where OpenGL runs on the processor, it would take the time of the physics
    os.nice(10)
    client = pybullet.connect(pybullet.GUI, options=_OPTIONS)
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=client)
    add_floor(client)
    if settings.physics.world != 'empty':
        urdf = read_world(settings.physics.world, worlds)
        load_urdf(one_colour_a_link(urdf), client, fixed=True)
    painted = dataclasses.replace(description, urdf=one_colour_a_link(description.urdf))
    robot = Robot(painted, settings.drive, settings.spawn, client)
    pybullet.resetDebugVisualizerCamera(physicsClientId=client, **_CAMERA)
    try:
        while pybullet.isConnected(physicsClientId=client):
            pose = receiver.recv()
            while receiver.poll():
                pose = receiver.recv()
            robot.place(pose)
    except (EOFError, pybullet.error):
        pass
