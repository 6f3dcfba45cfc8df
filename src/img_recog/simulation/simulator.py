"""World and vehicles, advanced together by whole steps."""
from typing import List, Sequence

import pybullet

from img_recog.simulation.vehicle import Reading, Vehicle
from img_recog.simulation.world import World

_MAX_CONTACT_DEPTH_M = 0.005


class Simulator:
    """Vehicles in a world.

    Each step has a fixed order: the drives set the motors, the physics advances, and the sensors
    that are due are read. Time is the number of steps multiplied by the step.
    """

    def __init__(self, world: World, vehicles: Sequence[Vehicle]):
        self.world, self.vehicles = world, vehicles
        self._steps = 0

    @property
    def time_s(self) -> float:
        """The simulated time."""
        return self._steps * self.world.step_s

    def advance(self, steps: int) -> List[Reading]:
        """Advance by a number of steps; return the readings of the sensors, in order of time."""
        readings: List[Reading] = []
        end = self._steps + steps
        while self._steps < end:
            for vehicle in self.vehicles:
                vehicle.before_step(self._steps)
            stop = min(vehicle.next_event(self._steps) for vehicle in self.vehicles)
            stop = min(stop, end)
            self.world.step(stop - self._steps)
            self._steps = stop
            for vehicle in self.vehicles:
                readings.extend(vehicle.after_step(self._steps, self.time_s))
        return readings

    def overlaps(self) -> List[str]:
        """Return which robots overlap with which bodies, as 'A in B', deeper than contacts do."""
        client = self.world.physics_client_id
        bodies = [self.world.floor, *self.world.bodies,
                  *(vehicle.robot for vehicle in self.vehicles)]
        names = {body.body_id: body.name for body in bodies}
        pybullet.performCollisionDetection(physicsClientId=client)
        found: List[str] = []
        for vehicle in self.vehicles:
            for contact in pybullet.getContactPoints(vehicle.robot.body_id,
                                                     physicsClientId=client):
                words = '{} in {}'.format(vehicle.robot.name, names[contact[2]])
                if contact[8] < -_MAX_CONTACT_DEPTH_M and words not in found:
                    found.append(words)
        return found

    def reset_world(self) -> None:
        """Move everything back to its start, at rest and without a command; time goes on."""
        self.world.reset()
        for vehicle in self.vehicles:
            vehicle.reset()

    def reset_simulation(self) -> None:
        """Do what `reset_world` does, and set the time to 0."""
        self.reset_world()
        self._steps = 0
