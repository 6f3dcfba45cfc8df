"""Steps in an environment of turtlebot3_dqn, by an agent that turns to the goal."""
import importlib
import math
import queue
import sys
import threading
from typing import Any, Callable, List, NamedTuple, Sequence, Tuple

import rospy

from img_recog.errors import UserError, one_line
from img_recog.messages import message

_ACTIONS = 5            # from a turn to the left to one to the right; the third drives straight on
_HEADING_RAD = 0.3      # between the headings for two of them
_HEADING = -4           # in the state: to the goal, rad
GOAL_REWARD = 200      # of the environment; a collision is -200
_STEP_S, _PLACE_S = 60.0, 10.0      # of wall time
_NEAR_M = 0.01

Point = Tuple[float, float]


class Goal(NamedTuple):
    """A goal that was reached. where: m; is_shown: whether its model stands there in Gazebo."""

    where: Point
    is_shown: bool
    steps: int


class Result(NamedTuple):
    """What the steps were. time_s: simulated."""

    rewards: List[float]
    goals: List[Goal]
    collisions: int
    resets: int
    time_s: float


def action_for(state: Sequence[float]) -> int:
    """Return the action that turns the robot to the goal."""
    turn = round(state[_HEADING] / _HEADING_RAD)
    return min(max(_ACTIONS // 2 - turn, 0), _ACTIONS - 1)


def run(folder: str, steps: int) -> Result:
    """Make steps in environment_stage_1.py in a folder.

    They are made in another thread: the environment waits for the next scan for ever, and catches
    all errors meanwhile, also that of Ctrl-C.
    """
    rospy.set_param('/stage_number', 1)
    sys.path.insert(0, folder)          # as it imports respawnGoal.py
    outcomes: 'queue.Queue[Callable[[], Any]]' = queue.Queue()

    def work() -> None:
        try:
            result = _steps(importlib.import_module('environment_stage_1'), steps,
                            lambda: outcomes.put(lambda: None))
        except Exception as error:
            problem = UserError(message('{} has failed: {}', folder, one_line(error)),
                                message('see doc/manual.md'))

            def fail(problem=problem):
                raise problem
            outcomes.put(fail)
        else:
            outcomes.put(lambda: result)
    threading.Thread(target=work, daemon=True).start()
    while True:
        try:
            result = outcomes.get(timeout=_STEP_S)()
        except queue.Empty:
            raise UserError(message('the environment has made no step for {} s', int(_STEP_S)),
                            message('see what the nodes have printed above'))
        if result is not None:
            return result


def _steps(module: Any, count: int, tell: Callable[[], None]) -> Result:
    environment = module.Env(_ACTIONS)
    state, begin = environment.reset(), rospy.get_time()
    rewards: List[float] = []
    goals: List[Goal] = []
    collisions, resets, first = 0, 1, 0
    where, is_shown = _goal(environment)
    for number in range(1, count + 1):
        state, reward, is_over = environment.step(action_for(state))
        rewards.append(float(reward))
        if reward == GOAL_REWARD:
            goals.append(Goal(where, is_shown, number - first))
            first = number
            where, is_shown = _goal(environment)
        if is_over:
            collisions, resets = collisions + 1, resets + 1
            state = environment.reset()
        tell()
    return Result(rewards, goals, collisions, resets, rospy.get_time() - begin)


def _goal(environment: Any) -> Tuple[Point, bool]:
    """Return where the goal is, and whether its model is there."""
    from gazebo_msgs.msg import ModelStates
    x, y = map(float, environment.getGoal())
    where = x, y
    end = rospy.get_rostime().to_sec() + _PLACE_S
    while rospy.get_rostime().to_sec() < end:
        states = rospy.wait_for_message('gazebo/model_states', ModelStates, _PLACE_S)
        poses = dict(zip(states.name, states.pose))
        if 'goal' in poses:
            position = poses['goal'].position
            if math.dist((position.x, position.y), where) < _NEAR_M:
                return where, True
    return where, False
