"""The physics client, and everything in it except robots."""
from typing import Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import pybullet

from img_recog.errors import SimulationError, shortened
from img_recog.formats.problems import Problems
from img_recog.formats.world_file import WorldFile
from img_recog.model import PLANE, AttachedFrame, Friction, Link, Model, Shape, Solid, Tree
from img_recog.simulation.physics import (build, crowding, friction, gears, standing, stiffness,
                                          tires)
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import all_or_nothing, client_argument
from img_recog.simulation.physics.directions import Directions
from img_recog.simulation.physics.forces import Forces
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.meeting import Meeting
from img_recog.simulation.physics.pushes import Pushes
from img_recog.simulation.physics.sleeping import Sleeping
from img_recog.simulation.physics.solids import Solids
from img_recog.simulation.simulation_settings import PhysicsSettings

_UPDATE_STEPS = 10      # between two updates of friction and contacts
# Gazebo's ground_plane, as it is included without a pose
FLOOR = Tree('ground_plane', Model('ground_plane', (
    Link('link', solids=(Solid(Shape(PLANE, (100.0, 100.0)), friction=Friction(100.0, 50.0)),)),),
    frames={'link': AttachedFrame('link')}), fixed=True)


class _Adopted(NamedTuple):
    """What makes a body act like in Gazebo; gears: PyBullet's numbers of their constraints."""

    landing: stiffness.Landing
    gears: List[int]
    forces: Forces
    directions: Directions


class World:
    """A physics client with gravity and the bodies of a world file.

    physics_client_id: to be passed to every PyBullet call; step_s: of the physics; solids: of all
    bodies in the client; floor: None in a world without; file: what stands in the world now;
    bodies: one for each tree in `file`; pushes: that act for a time; sleeping: the bodies that
    can fall asleep; revision: the number of times that something was added or removed, robots
    too, or that something fixed was moved for the first time; lifted: how far, in m, each body
    was moved upward that was in the floor when it was added, by name; crowded: a line if the
    step after the last `add` takes long; warnings: what else of that `add` is simulated in
    another way, a line each.
    """

    def __init__(self, settings: PhysicsSettings, file: WorldFile, physics_client_id: int,
                 problems: Optional[Problems] = None):
        """Build the world in a physics client.

        problems: to which is added what of the file cannot be loaded; without, that is a
        SimulationError.
        """
        self.physics_client_id, self.step_s = physics_client_id, settings.step_s
        self.client = client_argument(physics_client_id)
        self.solids, self._meeting = Solids(physics_client_id), Meeting(physics_client_id)
        self._adopted: Dict[int, _Adopted] = {}
        self.pushes, self.sleeping = Pushes(), Sleeping(physics_client_id, settings.step_s)
        self.file, self.revision = file._replace(trees=()), 0
        self.bodies: List[FramedBody] = []
        self.lifted: Dict[str, float] = {}
        self.set_gravity(file.gravity)
        # Contacts in a fixed order, so that equal commands give equal trajectories; and each group
        # of bodies that touch by itself, as ODE does, which makes 60 crates three times as fast.
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=settings.step_s, deterministicOverlappingPairs=1,
            minimumSolverIslandSize=1, **self.client)
        self._pairs = friction.Pairs(physics_client_id, self._meeting.forget_contacts_of)
        self._pairs_revision, self._steps = -1, 0
        self._is_at_start = True
        self.floor: Optional[FramedBody] = None
        if file.has_floor:
            (_, self.floor), = load_bodies([FLOOR], physics_client_id)
            friction.set_dynamics(self.floor)
            self._meeting.add([self.floor])
            self.sleeping.add(self.floor)
        try:
            self.add(file.trees, problems)
        except SimulationError as error:
            raise SimulationError('world {}: {}'.format(file.name, error.problem), error.advice)

    def add(self, trees: Sequence[Tree], problems: Optional[Problems] = None) -> None:
        """Add trees to the world.

        problems: to which is added what cannot be loaded; without, that is a SimulationError, and
        nothing is added. A next step that would take too long is a SimulationError too.
        """
        with all_or_nothing(self.physics_client_id):
            loaded = load_bodies(trees, self.physics_client_id, problems=problems)
            self.warnings = self._adopt_trees(loaded)
            try:
                self.crowded = crowding.check([*self.bodies, *(body for _, body in loaded)])
            except SimulationError:
                for _, body in loaded:
                    self._remove(body)
                raise
        planes = self._planes(body for _, body in loaded)
        for tree, body in loaded:
            if any(tree.positions.values()):
                for joint in body.joints:
                    body.set_joint(joint, tree.positions.get(joint, 0.0))
                body.keep_as_start()
            friction.set_dynamics(body)
            if body.fixed and body.joints:
                for plane in planes:
                    self._free_of(plane, body)
            elif not body.fixed:
                lifted = standing.lift(body, planes)
                if lifted.onto:
                    body.keep_as_start()
                    self.lifted[body.name] = lifted.height_m
            self.sleeping.add(body, bool(self._adopted[body.body_id].forces))
            self.sleeping.wake_near(body)
        self.bodies += [body for _, body in loaded]
        self.file = self.file._replace(trees=(*self.file.trees, *(tree for tree, _ in loaded)))
        self.notify_changed()

    @property
    def fixed(self) -> List[FramedBody]:
        """The bodies that never move, and the floor."""
        return [body for body in (self.floor, *self.bodies) if body is not None and body.fixed]

    def set_gravity(self, gravity: Tuple[float, ...]) -> None:
        """Let another gravity (3,) act from the next step on, in m/s2."""
        pybullet.setGravity(*gravity, **self.client)
        self.file = self.file._replace(gravity=gravity)
        for adopted in self._adopted.values():
            adopted.forces.gravity = gravity
        self.sleeping.wake()

    def lift(self, body: Body) -> standing.Lift:
        """Move a robot upward until it is in nothing, see `standing.lift`."""
        others = [other for other in self.bodies if not other.is_plane]
        return standing.lift(body, self._planes(), others)

    def _planes(self, added: Iterable[Body] = ()) -> List[Body]:
        return [body for body in (self.floor, *self.bodies, *added) if body and body.is_plane]

    def _free_of(self, plane: Body, body: Body) -> None:
        """Let what a joint holds deep in a plane not meet it: nothing could push it out."""
        for link in standing.links_in(body, plane):
            self._meeting.part(body, link, plane, -1)
            self.warnings.append('{}: held in the floor by its joints; it does not meet the floor'
                                 .format(body.name))

    def _adopt_trees(self, loaded: Sequence[Tuple[Tree, FramedBody]]) -> List[str]:
        models: List[List[FramedBody]] = []
        for tree, body in loaded:
            if tree.first:
                models.append([])
            models[-1].append(body)
        return [line for bodies in models for line in self.adopt(bodies)]

    def adopt(self, bodies: Sequence[FramedBody]) -> List[str]:
        """Let the bodies of a model act like in Gazebo, until they are removed.

        Returns warnings, a line each.
        """
        self._meeting.add(bodies)
        lines: List[str] = []
        for body in bodies:
            # before anything looks for contacts
            adopted = self._adopted[body.body_id] = _Adopted(
                stiffness.Landing(body, self._meeting.forget_contacts_of), gears.add(body),
                Forces(body, self.step_s, self.file.gravity), Directions(body))
            lines += ['{}: {}'.format(body.name, line) for line in adopted.forces.warnings]
        return lines

    def _remove(self, body: Body) -> None:
        self.sleeping.forget(body)
        self._meeting.forget(body)
        if body.body_id in self._adopted:       # unless it is frozen, see load_again
            for constraint in self._adopted.pop(body.body_id).gears:
                pybullet.removeConstraint(constraint, **self.client)
        self.pushes.forget(body)
        pybullet.removeBody(body.body_id, **self.client)

    def remove(self, bodies: Sequence[Body]) -> None:
        """Remove bodies from the world: some of `bodies`, or those of robots."""
        kept = [number for number, body in enumerate(self.bodies) if body not in bodies]
        for body in bodies:
            self._remove(body)
        self.bodies = [self.bodies[number] for number in kept]
        self.file = self.file._replace(trees=tuple(self.file.trees[number] for number in kept))
        self.notify_changed()

    def load_again(self, bodies: Sequence[FramedBody], freeze: bool = False) -> None:
        """Replace the bodies of a model in PyBullet, which simulates none again that had NaN.

        They are at the origin then. freeze: whether nothing moves them, nor their joints.
        """
        for body in bodies:
            held = [value[0] for value in body.joint_values()] if freeze else ()
            self._remove(body)
            # PyBullet gives the number that was free last
            build.load(body.loaded.held_at(dict(zip(body.joints, held))), self.physics_client_id,
                       body.fixed or freeze, problems=Problems(), exact_hulls=body.exact_hulls)
            body.set_defaults()
        self._meeting.add(bodies) if freeze else self.adopt(bodies)
        for body in bodies:
            friction.set_dynamics(body)
            body.stop_wheels()
        self._pairs.reset()
        self.notify_changed()

    def step(self, count: int = 1) -> None:
        """Advance the physics by a number of steps."""
        if self._pairs_revision != self.revision:
            self._pairs_revision, self._steps = self.revision, 0
            self._pairs.refresh()
        if self._is_at_start:
            self._is_at_start = False
            self._meeting.forget_contacts()
        # local names: this is the innermost loop
        step, client = pybullet.stepSimulation, self.client
        adopted = self._adopted.values()
        acting = [each.forces.apply for each in adopted if each.forces]
        if self.pushes:
            acting.append(self.pushes.apply)
        updates = [self._pairs.update] if self._pairs.needs_updates else []
        updates += [each.directions.update for each in adopted if each.directions]
        updates += [each.landing.update for each in adopted if each.landing]
        while count > 0:
            steps = count
            if self.sleeping:
                self.pushes.delay(self.sleeping.wake(self.pushes.bodies))
                steps = self.sleeping.before_steps(steps)
            for number in range(self._steps, self._steps + steps):
                for act in acting:
                    act()
                # also in each of the first steps, in which things come to rest on others
                if number < _UPDATE_STEPS or number % _UPDATE_STEPS == 0:
                    for update in updates:
                        update()
                step(**client)
            self._steps += steps
            count -= steps

    def close(self) -> None:
        """End the physics client; nothing of it can be used any more."""
        pybullet.disconnect(**self.client)

    def reset(self) -> None:
        """Move all bodies back to where they were when they were added, at rest."""
        self.pushes.clear()
        self.sleeping.reset()
        for body in self.bodies:
            body.reset()
        self._pairs.reset()
        for adopted in self._adopted.values():
            adopted.landing.reset()
        self._is_at_start, self._steps = True, 0

    def notify_changed(self) -> None:
        """Call after a body was added or removed."""
        self.revision += 1
        stiffness.set_up(self.physics_client_id, self.step_s, any(
            adopted.landing for adopted in self._adopted.values()))
        self.solids.others = {body.body_id for body in self.bodies if body.is_terrain}
        self.solids.forget()

    def notify_moved(self, bodies: Sequence[FramedBody]) -> None:
        """Call after bodies were moved; from then on, fixed ones among them can move, too."""
        for body in bodies:
            if self.sleeping.wake_near(body):
                self._meeting.set_masks(body)
            if body.fixed and not body.was_moved:
                body.was_moved = True
                self.revision += 1


def load_bodies(trees: Sequence[Tree], physics_client_id: int, visuals: bool = False,
                problems: Optional[Problems] = None) -> List[Tuple[Tree, FramedBody]]:
    """Load trees like `build.load`; return those that were loaded, with their bodies.

    problems: to which is added what cannot be loaded; without, that is a SimulationError, and none
    is loaded.
    """
    loaded: List[Tuple[Tree, FramedBody]] = []
    is_first = True         # whether the model of the next tree has none yet
    with all_or_nothing(physics_client_id):
        for tree in trees:
            is_first |= tree.first
            try:
                shod = tree.model if tree.fixed else tires.added(tree.model)
                body = FramedBody(
                    build.load(shod, physics_client_id, tree.fixed, tree.pose, visuals, problems),
                    physics_client_id, tree.model, tree.fixed, shod)
            except SimulationError as error:
                refused = SimulationError('model {}: {}'.format(
                    shortened(tree.name), error.problem), error.advice)
                if problems is None:
                    raise refused
                problems.add(refused.problem, refused.advice)
                continue
            body.name, body.is_terrain = tree.name, tree.model.terrain is not None
            body.is_plane = tree.model.is_plane
            loaded.append((tree._replace(first=is_first), body))
            is_first = False
    return loaded
