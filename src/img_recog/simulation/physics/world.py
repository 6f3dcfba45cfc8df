"""The physics client, and the models in it."""
from typing import Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import pybullet

from img_recog.errors import SimulationError, shortened
from img_recog.formats.world_file import WorldFile
from img_recog.model import PLANE, AttachedFrame, Friction, Link, Model, Shape, Solid, Tree
from img_recog.report import LEFT_OUT, LIFTED, NOTE, Finding, Report
from img_recog.simulation.physics import build, crowding, standing, tires
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import all_or_nothing, client_argument
from img_recog.simulation.physics.forces import Forces
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.model_bodies import ModelBodies
from img_recog.simulation.physics.pushes import Pushes
from img_recog.simulation.physics.sleeping import Sleeping
from img_recog.simulation.physics.solids import Solids
from img_recog.simulation.physics.surfaces import Surfaces
from img_recog.simulation.simulation_settings import PhysicsSettings

_UPDATE_STEPS = 10      # between two updates of friction and contacts
# Gazebo's ground_plane, as it is included without a pose
FLOOR = Tree('ground_plane', Model('ground_plane', (
    Link('link', solids=(Solid(Shape(PLANE, (100.0, 100.0)), friction=Friction(100.0, 50.0)),)),),
    frames={'link': AttachedFrame('link')}), fixed=True)


class _Adopted(NamedTuple):
    """What makes a body act like in Gazebo; gears: PyBullet's numbers of their constraints."""

    gears: List[int]
    forces: Forces


class World:
    """A physics client with gravity and models.

    Attributes:
        physics_client_id: Number of the client, to be passed to every PyBullet call.
        step_s: Step of the physics.
        solids: Collision shapes of all bodies in the client.
        models: All models: the floor, if there is one, then the others as they were added.
        floor: Body of the floor; None in a world without.
        file: What the world file says besides the models, with the gravity of now.
        pushes: Forces that act for a time.
        sleeping: Bodies that can fall asleep.
        revision: Number of times that a model was added or removed, or that something fixed was
            moved for the first time.
        report: Gets what is simulated in another way than the files ask.
    """

    def __init__(self, settings: PhysicsSettings, file: WorldFile, physics_client_id: int,
                 report: Optional[Report] = None,
                 make: Callable[..., ModelBodies] = ModelBodies):
        """Build the world in a physics client.

        Args:
            settings: Settings of the physics.
            file: World.
            physics_client_id: Number of the client.
            report: Gets what of the file cannot be loaded; without it, that is an error.
            make: Class of the models of the file.

        Raises:
            SimulationError: if something cannot be loaded, or the first step would take too long.
        """
        self.physics_client_id, self.step_s = physics_client_id, settings.step_s
        self.client = client_argument(physics_client_id)
        self.solids = Solids(physics_client_id)
        self._surfaces = Surfaces(physics_client_id, settings.step_s)
        self._adopted: Dict[int, _Adopted] = {}
        self._acting: List[Callable[[], None]] = []         # forces of the adopted bodies
        self.pushes, self.sleeping = Pushes(), Sleeping(physics_client_id, settings.step_s)
        self.file, self.revision = file._replace(trees=()), 0
        self.models: List[ModelBodies] = []
        self._make = make
        self.report = Report('world ' + file.name) if report is None else report
        self.set_gravity(file.gravity)
        # Contacts in a fixed order, so that equal commands give equal trajectories; and each group
        # of bodies that touch by itself, as ODE does, which makes 60 crates three times as fast.
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=settings.step_s, deterministicOverlappingPairs=1,
            minimumSolverIslandSize=1, **self.client)
        self._surfaces_revision, self._steps = -1, 0
        self._is_at_start = True
        self.floor: Optional[FramedBody] = None
        if file.has_floor:
            (_, self.floor), = load_bodies([FLOOR], physics_client_id)
            self.models.append(ModelBodies(FLOOR.name, [FLOOR], [self.floor]))
            Surfaces.set_friction(self.floor)
            self._surfaces.add([self.floor])
            self.sleeping.add(self.floor)
        try:
            self.load(file.trees, report)
        except SimulationError as error:
            raise SimulationError('world {}: {}'.format(file.name, error.problem), error.advice)

    def load(self, trees: Sequence[Tree],
             report: Optional[Report] = None) -> Sequence[ModelBodies]:
        """Load trees into PyBullet, and add their models.

        Args:
            trees: Trees of the models.
            report: Gets what cannot be loaded; without it, that is an error.

        Returns:
            The models.

        Raises:
            SimulationError: if something cannot be loaded, or a next step would take too long;
                nothing is added then.
        """
        with all_or_nothing(self.physics_client_id):
            models: List[ModelBodies] = []
            for tree, body in load_bodies(trees, self.physics_client_id, report=report):
                if tree.first:
                    models.append(self._make(body.name, [], []))
                models[-1].trees.append(tree)
                models[-1].bodies.append(body)
            self.add(models)
        return models

    def add(self, models: Sequence[ModelBodies]) -> None:
        """Add models that are in PyBullet.

        Raises:
            SimulationError: if the next step would take too long; the models are removed then.
        """
        for model in models:
            self._connect(model.bodies, self.report)
        added = [(tree, body) for model in models if not model.is_robot
                 for tree, body in zip(model.trees, model.bodies)]
        if added:
            is_alone = len(models) == 1
            report = self.report.about('model ' + models[0].name) if is_alone else self.report
            try:
                crowding.check([*self.scenery, *(body for _, body in added)], report)
            except SimulationError:
                self._remove(models)
                raise
            self._settle(added)
        for model in models:
            model.name = self._free_name(model.name)
            self.models.append(model)
        self.notify_changed()

    def _settle(self, added: Sequence[Tuple[Tree, FramedBody]]) -> None:
        """Put joints at their first positions, and what is in the floor onto it."""
        planes, findings = self._planes(body for _, body in added), []
        for tree, body in added:
            if any(tree.positions.values()):
                for joint in body.joints:
                    body.set_joint(joint, tree.positions.get(joint, 0.0))
                body.keep_as_start()
            Surfaces.set_friction(body)
            body.release_joints()
            if body.fixed and body.joints:
                for plane in planes:
                    self._free_of(plane, body)
            elif not body.fixed:
                lifted = standing.lift(body, planes)
                if lifted.onto:
                    body.keep_as_start()
                    findings.append(Finding(LIFTED, '{} by {:.3f} m'.format(
                        body.name, lifted.height_m)))
            self.sleeping.add(body, bool(self._adopted[body.body_id].forces))
            self.sleeping.wake_near(body)
        self.report.extend(findings)        # together, so that they are one line

    def _free_name(self, name: str) -> str:
        """Return a name that no model has, as Gazebo makes it of one that is taken."""
        taken = {model.name for model in self.models}
        number, free = 0, name
        while free in taken:
            free, number = '{}_{}'.format(name, number), number + 1
        return free

    @property
    def bodies(self) -> List[FramedBody]:
        """The bodies of all models but the floor."""
        return [body for model in self.models for body in model.bodies if body is not self.floor]

    @property
    def trees(self) -> List[Tree]:
        """The trees of links of `bodies`."""
        return [tree for model in self.models for tree in model.trees if tree is not FLOOR]

    @property
    def scenery(self) -> List[FramedBody]:
        """The bodies of all models but the floor and robots."""
        return [body for model in self.models if not model.is_robot
                for body in model.bodies if body is not self.floor]

    @property
    def fixed(self) -> List[FramedBody]:
        """The bodies that never move, and the floor."""
        return [body for body in (self.floor, *self.scenery) if body is not None and body.fixed]

    def set_gravity(self, gravity: Tuple[float, ...]) -> None:
        """Let another gravity (3,) act from the next step on, in m/s2."""
        pybullet.setGravity(*gravity, **self.client)
        self.file = self.file._replace(gravity=gravity)
        for adopted in self._adopted.values():
            adopted.forces.gravity = gravity
        self.sleeping.wake()

    def lift(self, body: Body) -> standing.Lift:
        """Move a robot upward until it is in nothing, see `standing.lift`."""
        others = [other for other in self.scenery if not other.is_plane]
        return standing.lift(body, self._planes(), others)

    def _planes(self, added: Iterable[Body] = ()) -> List[Body]:
        return [body for body in (*self.fixed, *added) if body.is_plane]      # a plane never moves

    def _free_of(self, plane: Body, body: Body) -> None:
        """Let what a joint holds deep in a plane not meet it: nothing could push it out."""
        for link in standing.links_in(body, plane):
            self._surfaces.disable_collision(body.body_id, plane.body_id, link, -1)
            self.report.about('model ' + body.name).add(
                NOTE, 'held in the floor by its joints; it does not meet the floor')

    def _connect(self, bodies: Sequence[FramedBody], report: Report) -> None:
        """Let the bodies of a model act like in Gazebo."""
        self._surfaces.add(bodies)
        for body in bodies:
            self._adopted[body.body_id] = _Adopted(body.add_gears(), Forces(
                body, self.step_s, self.file.gravity, report.about('model ' + body.name)))

    def _remove_body(self, body: Body) -> None:
        self.sleeping.forget(body)
        self._surfaces.forget(body)
        if body.body_id in self._adopted:       # unless it is frozen, see load_again
            for constraint in self._adopted.pop(body.body_id).gears:
                pybullet.removeConstraint(constraint, **self.client)
        self.pushes.forget(body)
        pybullet.removeBody(body.body_id, **self.client)

    def remove(self, model: ModelBodies) -> None:
        """Remove a model from the world."""
        self._remove([model])
        self.models.remove(model)
        self.notify_changed()

    def _remove(self, models: Sequence[ModelBodies]) -> None:
        for model in models:
            for body in model.bodies:
                self._remove_body(body)

    def load_again(self, model: ModelBodies, freeze: bool = False) -> None:
        """Replace the bodies of a model in PyBullet, which simulates none again that had NaN.

        They are at the origin then.

        Args:
            model: Model.
            freeze: Whether nothing moves the bodies and their joints.
        """
        for body in model.bodies:
            held = [value[0] for value in body.joint_values()] if freeze else ()
            self._remove_body(body)
            # PyBullet gives the number that was free last
            build.load(body.loaded.held_at(dict(zip(body.joints, held))), self.physics_client_id,
                       body.fixed or freeze, report=Report(), exact_hulls=body.exact_hulls)
            body.set_defaults()
        if freeze:
            self._surfaces.add(model.bodies, freeze)
        else:
            self._connect(model.bodies, Report())
        for body in model.bodies:
            Surfaces.set_friction(body)
            body.release_joints()
            body.stop_wheels()
        model.notify_loaded_again()
        self._surfaces.reset()
        self.notify_changed()

    def step(self, count: int = 1) -> None:
        """Advance the physics by a number of steps."""
        if self._surfaces_revision != self.revision:
            self._surfaces_revision, self._steps = self.revision, 0
            self._surfaces.refresh()
            self._acting = [adopted.forces.apply for adopted in self._adopted.values()
                            if adopted.forces]
        if self._is_at_start:
            self._is_at_start = False
            self._surfaces.forget_contacts()
        # local names: this is the innermost loop
        step, client = pybullet.stepSimulation, self.client
        surfaces, updates = self._surfaces, self._surfaces.needs_updates
        acting = self._acting + ([self.pushes.apply] if self.pushes else [])
        while count > 0:
            steps = count
            if self.sleeping:
                self.pushes.delay(self.sleeping.wake(self.pushes.bodies))
                steps = self.sleeping.before_steps(steps)
            for number in range(self._steps, self._steps + steps):
                for act in acting:
                    act()
                # also in each of the first steps, in which things come to rest on others
                if updates and (number < _UPDATE_STEPS or number % _UPDATE_STEPS == 0):
                    surfaces.update()
                step(**client)
            self._steps += steps
            count -= steps

    def close(self) -> None:
        """End the physics client; nothing of it can be used any more."""
        pybullet.disconnect(**self.client)

    def reset(self) -> None:
        """Move all models back to their starts, at rest and without a command."""
        self.pushes.clear()
        self.sleeping.reset()
        # robots last: they are lifted onto what they start in
        for model in sorted(self.models, key=lambda model: model.is_robot):
            model.reset()
        self._surfaces.reset()
        self._is_at_start, self._steps = True, 0

    def notify_changed(self) -> None:
        """Call after a model was added or removed, or loaded again."""
        self.revision += 1
        self.solids.others = {body.body_id for body in self.scenery if body.is_terrain}
        self.solids.forget()

    def notify_moved(self, model: ModelBodies, bodies: Sequence[FramedBody]) -> None:
        """Call after bodies of a model were moved; from then on, a fixed one can move, too."""
        model.notify_moved(bodies)
        for body in bodies:
            if self.sleeping.wake_near(body):
                self._surfaces.set_filters(body)
            if body.fixed and not body.was_moved:
                body.was_moved = True
                self.revision += 1


def load_bodies(trees: Sequence[Tree], physics_client_id: int, visuals: bool = False,
                report: Optional[Report] = None) -> List[Tuple[Tree, FramedBody]]:
    """Load trees like `build.load`; return those that were loaded, with their bodies.

    report: gets what cannot be loaded; without, that is a SimulationError, and none is loaded.
    """
    loaded: List[Tuple[Tree, FramedBody]] = []
    is_first = True         # whether the model of the next tree has none yet
    with all_or_nothing(physics_client_id):
        for tree in trees:
            is_first |= tree.first
            try:
                shod = tree.model if tree.fixed else tires.added(tree.model)
                body = FramedBody(
                    build.load(shod, physics_client_id, tree.fixed, tree.pose, visuals, report),
                    physics_client_id, tree.model, tree.fixed, shod)
            except SimulationError as error:
                refused = SimulationError('model {}: {}'.format(
                    shortened(tree.name), error.problem), error.advice)
                if report is None:
                    raise refused
                report.add(LEFT_OUT, refused.problem, advice=refused.advice)
                continue
            body.name, body.is_terrain = tree.name, tree.model.terrain is not None
            body.is_plane = tree.model.is_plane
            loaded.append((tree._replace(first=is_first), body))
            is_first = False
    return loaded
