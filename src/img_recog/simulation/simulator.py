"""A world with its robots and sensors, advanced together by whole steps."""
from typing import Any, Callable, Collection, Dict, List, Optional, Sequence, Set, Union

from img_recog import rotations
from img_recog.report import NOTE
from img_recog.simulation.guard import Guard
from img_recog.simulation.physics import tires
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.standing import MAX_DEPTH_M
from img_recog.simulation.physics.world import World
from img_recog.simulation.sensors import ray_sensor
from img_recog.simulation.sensors.ray_sensor import RaySensor
from img_recog.simulation.sensors.sensor import Sensor
from img_recog.simulation.simulated_model import MountedSensors, Reading, Robot, SimulatedModel

_STEEP = 0.7        # vertical part of the normal of a contact: 45 degrees
# m/s: nothing in a world of robots is as fast, so the physics has thrown it
_IMPOSSIBLE = 1000.0
_LOOK_STEPS = 1000      # between two looks for that, and for robots that cannot drive
_HANGING_LOOKS = 2      # in a row: at the start, a robot may still fall
_UPRIGHT = 0.95         # vertical part of the z axis of a robot: 18 degrees


class Simulator:
    """A world whose robots drive and whose sensors are read.

    Each step has a fixed order: the drives set the motors, the physics advances, and the sensors
    that are due are read. Time is the number of steps multiplied by the step.

    Attributes:
        world: World.
        steps: Simulated time in steps of the physics.
        after_step: Called after each step of the physics, if it is set.
    """

    def __init__(self, world: World):
        self.world = world
        self.steps = 0
        self.after_step: Optional[Callable[[], None]] = None
        self._flying: Set[str] = set()
        self._hanging: Dict[str, int] = {}      # looks in a row at which a robot hung, by its name
        self._told: Set[str] = set()            # robots of which a line said that
        self._guard = Guard(world)

    @property
    def models(self) -> List[SimulatedModel]:
        """The models of the world that can have sensors: all but the floor."""
        return [model for model in self.world.models if isinstance(model, SimulatedModel)]

    @property
    def robots(self) -> List[Robot]:
        """The models with a drive, in the order in which they were added."""
        return [model for model in self.world.models if isinstance(model, Robot)]

    @property
    def sensors(self) -> List[MountedSensors]:
        """The sensors of all models."""
        return [mounted for model in self.models for mounted in model.sensors]

    @property
    def time_s(self) -> float:
        """The simulated time."""
        return self.steps * self.world.step_s

    def next_reading(self, kinds: Collection[str]) -> Optional[int]:
        """Return the next step at which a sensor of some kinds is read; None if there is none."""
        return min((each.next_reading(self.steps) for mounted in self.sensors
                    for each in mounted.enabled if each.kind in kinds), default=None)

    def advance(self, steps: int) -> List[Reading]:
        """Advance by a number of steps; return the readings of the sensors, in order of time."""
        readings: List[Reading] = []
        end = self.steps + steps
        self._guard.before_steps(self.steps)
        robots, sensors = self.robots, self.sensors
        timed: List[Union[Robot, MountedSensors]] = [*robots, *sensors]
        for mounted in sensors:
            mounted.before_step(self.steps)
        while self.steps < end:
            for robot in robots:
                robot.before_step(self.steps)
            stop = min((each.next_event(self.steps) for each in timed), default=end)
            begin, stop = self.steps, min(stop, end)
            while self.after_step is not None and self.steps < stop:
                self.world.step()
                self.steps += 1
                self.after_step()
            self.world.step(stop - self.steps)
            self.steps = stop
            self._guard.look(stop)
            if stop // _LOOK_STEPS > begin // _LOOK_STEPS:
                self._look_for_flights()
                self._look_for_hanging_wheels()
            readings.extend(self._read(sensors))
        return readings

    def _look_for_flights(self) -> None:
        for body in self.world.bodies:
            if body.fixed or body.name in self._flying:
                continue
            speed = body.speed()
            if not speed < _IMPOSSIBLE:     # also NaN
                self._flying.add(body.name)
                self.world.report.about('').add(
                    NOTE, '{} moves at {:.3g} m/s, after {:g} s: the physics has thrown it, most '
                    'often because it was pushed into something that cannot give way; reset '
                    'the world or move it'.format(body.name, speed, self.time_s))

    def _look_for_hanging_wheels(self) -> None:
        """Warn of each robot that stands on other links than its driven wheels, once."""
        for robot in self.robots:
            name, links = robot.body.name, _standing_on(robot)
            self._hanging[name] = self._hanging.get(name, 0) + 1 if links else 0
            if self._hanging[name] == _HANGING_LOOKS and name not in self._told:
                self._told.add(name)
                self.world.report.about(name).add(
                    NOTE, 'no driven wheel touches anything, it stands on {}; lower its wheels, '
                    'or raise what it stands on'.format(', '.join(links)))

    def _read(self, sensors: Sequence[MountedSensors]) -> List[Reading]:
        """Return the readings of the sensors that are due now."""
        due = [each for mounted in sensors for each in mounted.due(self.steps)]
        if not due:         # most often
            return []
        values = _read_together([each.sensor for each in due])
        return [Reading(each.robot, each.name, each.kind, self.time_s, value)
                for each, value in zip(due, values)]

    def overlaps(self) -> List[str]:
        """Return which robots overlap with which bodies, as 'A in B', deeper than contacts do.

        Two robots are one line.
        """
        pairs = {frozenset((robot.name, name)): '{} in {}'.format(robot.body.name, name)
                 for robot in reversed(self.robots)
                 for name in reversed(self.overlapped(robot.body))}
        return list(pairs.values())[::-1]

    def overlapped(self, body: Body) -> List[str]:
        """Return the names of the bodies that a robot overlaps with, deeper than contacts do."""
        names = {each.body_id: each.name for model in self.world.models for each in model.bodies}
        deep = [names.get(contact.other, body.name)
                for contact in body.contacts(detect=True) if contact.depth_m > MAX_DEPTH_M]
        return list(dict.fromkeys(deep))

    def touched(self, body: Body) -> List[str]:
        """Return the names of the bodies that touch a robot from the side.

        What it stands on does not.
        """
        found = {contact.other for contact in body.contacts()
                 if contact.other != body.body_id and contact.depth_m >= 0
                 and abs(contact.up) < _STEEP}
        if not found:       # most often
            return []
        return sorted(each.name for each in self.world.bodies if each.body_id in found)

    def close(self) -> None:
        """End the physics; nothing of it can be used any more."""
        self.world.close()

    def reset_world(self) -> None:
        """Move everything back to its start, at rest and without a command; time goes on."""
        self._guard.reset()
        self.world.reset()
        self._flying.clear()
        self._hanging.clear()
        for mounted in self.sensors:
            mounted.reset()
        for robot in self.robots:
            robot.drives_from = self.steps

    def reset_simulation(self) -> None:
        """Do what `reset_world` does, set the time to 0 and let all noise begin anew.

        Equal commands then give equal motion and readings, to the last bit unless many jointed
        models touch one another.
        """
        self.steps = 0
        self.reset_world()
        for mounted in self.sensors:
            mounted.restart_noise()


def _read_together(sensors: Sequence[Sensor]) -> List[Any]:
    """Return what each of the sensors measures now."""
    cast = [sensor for sensor in sensors if isinstance(sensor, RaySensor)]
    measured = iter(ray_sensor.read_together(cast) if cast else ())
    return [next(measured) if isinstance(sensor, RaySensor) else sensor.read()
            for sensor in sensors]


def _standing_on(robot: Robot) -> List[str]:
    """Return the links on which a robot stands upright, if none of them is a driven wheel."""
    body, drive = robot.body, robot.settings.drive
    names = {index: tires.owner(name) for name, index in body.link_indices.items()}
    driven = {names[body.joints[name]] for name in (*drive.left_joints, *drive.right_joints)
              if name in body.joints}
    if not driven or rotations.matrix(body.pose().orientation)[2, 2] < _UPRIGHT:
        return []
    touching = {names[point.link] for point in body.contacts() if point.force > 0}
    return [] if touching & driven else sorted(touching)
