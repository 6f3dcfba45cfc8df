"""The task of each chapter: what the reader of the e-Manual does, and how well it went."""
import math
import os
import statistics
import sys

import rospkg
from chapters import GOAL_RADIUS, GOALS, PILLAR_RADIUS, PILLARS, START

from img_recog.errors import UserError
from img_recog.messages import message

_CORNERS = 2
_LANE_S = 240.0         # simulated, for two corners
_TEXTURE = 'models/turtlebot3_autorace_2020/course/materials/textures/course.png'


def say(text):
    """Print a line of ./run."""
    sys.stdout.write('[run] {}\n'.format(text))
    sys.stdout.flush()


def slam(reader, given):
    """Drive round, save the map, and return whether all pillars are in it, within one cell."""
    import occupancy
    say(message('driving round along the wall, about 2 min'))
    reader.explore()
    grid = reader.grid()
    path = os.path.join(given.dir, 'map')
    occupancy.save(grid, path)
    found = occupancy.find_pillars(grid, PILLARS, PILLAR_RADIUS)
    say(message('the map is in {}.yaml and {}.pgm', path, path))
    say(message('{} of {} pillars are in the map', len(found), len(PILLARS)))
    if len(found) < len(PILLARS):
        return False
    in_world, in_map = occupancy.errors(found)
    say(message('in the frame of the world, their centers are off by at most {} m, {} cells',
                *_figures(in_world, grid)))
    say(message('in the frame of the map, their centers are off by at most {} m, {} cells',
                *_figures(in_map, grid)))
    return in_map <= grid.resolution


def _figures(error_m, grid):
    return '{:.3f}'.format(error_m), '{:.2f}'.format(error_m / grid.resolution)


def navigation(reader, given):
    """Drive to the goals; return whether the robot came near all of them, and so move_base says.

    Near is GOAL_RADIUS, in the frame of the map, in which the goals are given: where the robot
    stands there follows from its true position and from the pillars in the map.
    """
    import occupancy
    reader.localize(START)
    found = occupancy.find_pillars(reader.grid(is_new=False), PILLARS, PILLAR_RADIUS)
    if len(found) < len(PILLARS):
        raise UserError(message('only {} of {} pillars are in the map', len(found), len(PILLARS)),
                        message('make it: ./run manual slam'))
    frame, is_good = occupancy.MapFrame(found), True
    for goal in given.goal or GOALS:
        end = reader.drive_to(goal)
        in_world = math.dist(end.position, goal[:2])
        in_map = math.dist(frame.from_world([end.position])[0], goal[:2])
        say(message('goal {} {}: {} after {} s, {} m from it in the frame of the map, '
                    '{} m in the frame of the world', *goal[:2], end.text,
                    '{:.0f}'.format(end.time_s), '{:.3f}'.format(in_map),
                    '{:.3f}'.format(in_world)))
        if end.is_reached and in_map > GOAL_RADIUS:
            say(message('that is too far: at most {} m are allowed', GOAL_RADIUS))
        is_good = is_good and end.is_reached and in_map <= GOAL_RADIUS
    return is_good


def dqn(_, given):
    """Make steps; return whether a goal was reached, and the models of all stood there."""
    import learning
    folder = os.path.join(rospkg.RosPack().get_path('turtlebot3_dqn'), 'src', 'turtlebot3_dqn')
    result = learning.run(folder, given.steps)
    for goal in result.goals:
        say(message('goal {} {}: reached after {} steps', *goal.where, goal.steps))
        if not goal.is_shown:
            say(message('its model was not there'))
    rewards = [reward for reward in result.rewards if abs(reward) != learning.GOAL_REWARD]
    say(message('{} steps in {} s of simulated time; goals reached: {}, collisions: {}, '
                'resets: {}', len(result.rewards), '{:.1f}'.format(result.time_s),
                len(result.goals), result.collisions, result.resets))
    say(message('rewards: sum {}, of the other steps {} to {}, mean {}', *map(
        '{:.1f}'.format, (sum(result.rewards), min(rewards, default=0.0),
                          max(rewards, default=0.0), statistics.mean(rewards or [0.0])))))
    return bool(result.goals) and all(goal.is_shown for goal in result.goals)


def autorace(reader, _):
    """Let the nodes drive round the corners; return whether the robot has not left its lane."""
    import cv2
    from course import Course, LaneDrive
    path = os.path.join(rospkg.RosPack().get_path('turtlebot3_gazebo'), _TEXTURE)
    picture = cv2.imread(path)
    if picture is None:
        raise UserError(message('there is no picture of the course: {}', path))
    drive = LaneDrive(Course(picture))
    time_s, images, lanes = reader.follow_lane(
        drive.add, lambda: drive.corners >= _CORNERS or not drive.is_inside, _LANE_S)
    say(message('the lane was found in {} of {} images', lanes, images))
    say(message('corners: {}, distance: {} m, in {} s of simulated time', drive.corners,
                '{:.2f}'.format(drive.driven_m), '{:.0f}'.format(time_s)))
    if drive.off_middle:
        say(message('distance from the middle of the lane: {} m in the mean, at most {} m', *map(
            '{:.3f}'.format, (statistics.mean(drive.off_middle), max(drive.off_middle)))))
    if not drive.is_inside:
        say(message('the robot has left its lane'))
    return drive.corners >= _CORNERS and drive.is_inside


TASKS = {'slam': slam, 'navigation': navigation, 'dqn': dqn, 'autorace': autorace}
