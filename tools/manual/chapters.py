"""The chapters of the e-Manual of TurtleBot3: what each needs, and what is started for it."""
from typing import Dict, NamedTuple, Sequence, Tuple


class Chapter(NamedTuple):
    """A chapter.

    summary: what is done. packages: of ROS, whose nodes and files are used. launch: package, file
    and arguments for roslaunch. noetic: packages of Ubuntu that have all that.
    """

    summary: str
    packages: Sequence[str]
    launch: Tuple[str, ...]
    noetic: Sequence[str]


CHAPTERS: Dict[str, Chapter] = {
    'slam': Chapter(
        'drive round turtlebot3_world, save the map, compare its pillars with the true ones',
        ('gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam'),
        ('turtlebot3_slam', 'turtlebot3_slam.launch', 'model:=burger', 'slam_methods:=gmapping'),
        ('ros-noetic-gmapping', 'ros-noetic-turtlebot3-slam')),
    'navigation': Chapter(
        'drive to goals on the map of slam, and compare with the true position',
        ('amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
         'turtlebot3_description', 'turtlebot3_navigation'),
        ('turtlebot3_navigation', 'turtlebot3_navigation.launch', 'model:=burger'),
        ('ros-noetic-dwa-local-planner', 'ros-noetic-turtlebot3-navigation')),
}

# what the package of turtlebot3_world is in Gazebo, m: the centers and the radius of the pillars
PILLARS = [(x, y) for x in (-1.1, 0.0, 1.1) for y in (-1.1, 0.0, 1.1)]
PILLAR_RADIUS = 0.15
START = (-2.0, -0.5)
# free places on three sides of the pillars, with the heading in rad
GOALS = ((0.55, -1.7, 0.0), (1.7, 0.55, 1.57), (-0.55, 1.7, 3.14))
GOAL_RADIUS = 0.1       # m, how near the robot has to come
