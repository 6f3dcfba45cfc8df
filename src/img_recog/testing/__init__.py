"""Tests of nodes that drive a simulated robot, in time that waits for them; see doc/ci.md.

    from img_recog.testing import Simulation

    with Simulation(launch=('my_package', 'drive.launch'), lockstep='cmd_vel') as sim:
        sim.wait_until(lambda: sim.pose().x > 1.0, timeout_s=20)

img_recog.testing.fixtures is a plugin of pytest with a fixture of it.
"""
from img_recog.testing.simulation import Simulation
from img_recog.testing.topics import Picture, Pose

__all__ = ['Picture', 'Pose', 'Simulation']
