"""A body whose links are known by the names that its file gives them."""
import math
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple, TypeVar

import pybullet

from img_recog.errors import SimulationError
from img_recog.formats.sdf_frames import WORLD
from img_recog.formats.sdf_models import BETWEEN_AXES
from img_recog.model import CONTINUOUS, AttachedFrame, Limits, Link, Model
from img_recog.rotations import Quaternion, Transform
from img_recog.simulation.physics.body import Body, FrameState, Motion, Vector, motion_of_frame
from img_recog.simulation.physics.tires import TREAD, owner, wheel_of

_HOLDING_FORCE = 1e6    # N or N m, of the motors of joints that are held at a position
_MAX_GEAR_FORCE = 1e9   # N or N m: more than a gear ever takes
_GEAR_ERP = 0.2         # share of an error of the positions that a gear takes back in a step

T = TypeVar('T')


class FramedBody(Body):
    """The body of a model: what sensors can be mounted on.

    model: what it was made of; loaded: the model that PyBullet has, with tires, by default the
    same; slides: whether it has no friction; driven: PyBullet's numbers of the joints that have
    motors of their own; exact_hulls: see `build.load`; link_names: of the links that Gazebo has,
    too: without those of a URDF that are parts of others, and without its `world`; first_axes: of
    each joint that moves, by its name, the name that its first axis has in `joints`.
    """

    slides, exact_hulls = False, False
    driven: Sequence[int] = ()

    def __init__(self, body_id: int, physics_client_id: int, model: Model, fixed: bool = False,
                 loaded: Optional[Model] = None):
        super().__init__(body_id, physics_client_id, fixed)
        self.model, self.loaded = model, loaded or model
        self._frames = model.frames or {
            link.name: AttachedFrame(link.name) for link in model.links}
        # the body of a plane or terrain is a part of a link of another body
        is_part = not model.frames and (model.is_plane or model.terrain is not None)
        self.link_names = [] if is_part else [
            name for name, frame in self._frames.items() if name == frame.link and name != WORLD]
        self.first_axes: Dict[str, str] = {}
        for axis in self.joints:
            self.first_axes.setdefault(axis.partition(BETWEEN_AXES)[0], axis)
        self._mounts: Dict[str, AttachedFrame] = {}
        self._surfaces = model.surfaces
        self._carriers: Dict[str, Tuple[int, Tuple[Vector, Quaternion]]] = {}

    def motion(self, frame: Optional[str] = None) -> Motion:
        """Return the motion of a link of the model, by default of the root link.

        Raises SimulationError when there is no such link.
        """
        # the root link may be one that the file does not have
        return super().motion() if frame is None else motion_of_frame(*self.frame_state(frame))

    def frame_state(self, frame: str) -> FrameState:
        """Return the state of a link of the model; errors as for `motion`."""
        return self.part_state(*self._carrier(frame))

    def push(self, link: str, force: Vector, torque: Vector) -> None:
        """Let a force and a torque act on a link in the next step, at its center of mass.

        force: (3,) in N, and torque: (3,) in N m; both along the axes of the world.
        """
        part, in_part = self._carrier(link)
        center = self.part_state(part, in_part).point
        pybullet.applyExternalForce(self.body_id, part, force, center, pybullet.WORLD_FRAME,
                                    **self.client)
        pybullet.applyExternalTorque(self.body_id, part, torque, pybullet.WORLD_FRAME,
                                     **self.client)

    def add_gears(self) -> List[int]:
        """Let the gears of the model hold; return PyBullet's numbers of their constraints.

        They must be removed before the body.
        """
        ids = [pybullet.createConstraint(
            self.body_id, self.joints[gear.joint], self.body_id, self.joints[gear.other],
            pybullet.JOINT_GEAR, [0, 0, 1], [0, 0, 0], [0, 0, 0], **self.client)
            for gear in self.model.gears]
        for constraint, gear in zip(ids, self.model.gears):
            pybullet.changeConstraint(constraint, gearRatio=gear.ratio, maxForce=_MAX_GEAR_FORCE,
                                      erp=_GEAR_ERP, **self.client)
        return ids

    def limits(self, joint: str) -> Limits:
        """Return the limits of the first axis of a joint, infinite where it has none."""
        for each in self.model.joints:
            if each.name == self.first_axes[joint] and each.limits is not None:
                return each.limits if each.kind != CONTINUOUS else each.limits._replace(
                    lower=-math.inf, upper=math.inf)
        return Limits(-math.inf, math.inf)

    def add_mount(self, frame: str, link: str, pose: Transform) -> None:
        """Add a frame with a constant pose in a link of the model.

        frame: a name that no link has. Its motion can be read like that of a link.
        """
        carrier = self._frames[link]
        self._mounts[frame] = AttachedFrame(carrier.link, carrier.pose @ pose)

    def surfaces(self, link: str) -> Dict[int, str]:
        """Return PyBullet's index and the name of each part with the shapes of a link.

        link: one with a contact sensor.
        """
        names = self._surfaces.get(link, ())
        return {index: owner(part) for part, index in self.link_indices.items()
                if wheel_of(part) in names}

    @property
    def with_treads(self) -> Set[str]:
        """Names of the wheels that have links with treads."""
        return {wheel_of(name) for name in self.link_indices if TREAD in name}

    def of_solids(self, read: Callable[[Link], T]) -> Dict[int, T]:
        """Return a value of each link with solids, by PyBullet's indices.

        Treads have the value of their wheel.
        """
        values = {link.name: read(link) for link in self.model.links if link.solids}
        return {index: values[wheel_of(name)] for name, index in self.link_indices.items()
                if wheel_of(name) in values}

    def release_joints(self) -> None:
        """Switch off the motors of the joints, of which PyBullet holds all.

        A joint keeps its friction, as in Gazebo. Motors of the drive stay as they are, and so do
        joints that the model holds.
        """
        for joint in self.model.joints:
            index = self.joints.get(joint.name)
            if index is None or index in self.driven:
                continue
            if math.isinf(joint.held):
                pybullet.setJointMotorControl2(
                    self.body_id, index, pybullet.POSITION_CONTROL, force=_HOLDING_FORCE,
                    targetPosition=joint.nearest_to_0, **self.client)
            else:
                friction = pybullet.getJointInfo(self.body_id, index, **self.client)[7]
                pybullet.setJointMotorControl2(self.body_id, index, pybullet.VELOCITY_CONTROL,
                                               force=joint.held or friction, **self.client)

    def stop_wheels(self) -> None:
        """Let the motors of the wheels hold them, if there are any."""

    def has_frame(self, frame: str) -> bool:
        """Return whether the model has this link."""
        return frame in self._frames

    def check_frame(self, setting: str, frame: str) -> None:
        """Raise SimulationError, naming the setting, when its value `frame` is not a link."""
        try:
            self._carrier(frame)
        except SimulationError as error:
            raise SimulationError('{}: {}'.format(setting, error.problem), error.advice)

    def _carrier(self, frame: str) -> Tuple[int, Tuple[Vector, Quaternion]]:
        """Return the PyBullet link that a frame is fixed to, and the frame's pose by `in_part`."""
        if frame not in self._carriers:
            found = self._frames.get(frame) or self._mounts.get(frame)
            if found is None:
                raise SimulationError('the robot has no link {} (links: {})'.format(
                    frame, ', '.join(sorted(self._frames))))
            name, pose = found
            link = self.link_indices[name]
            self._carriers[frame] = link, self.in_part(link, pose)
        return self._carriers[frame]
