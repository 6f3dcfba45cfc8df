"""The chapters of the e-Manual of TurtleBot3: what each needs, and what is started for it."""
from typing import Dict, NamedTuple, Sequence


class Chapter(NamedTuple):
    """A chapter.

    summary: what is done. packages: of ROS, whose nodes and files are used. noetic: packages of
    Ubuntu for them. launch: words for roslaunch; none if no node is started. demo: arguments of
    the demo. {NAME} in these words is the folder of a package, {here} that of this file.
    """

    summary: str
    packages: Sequence[str]
    noetic: Sequence[str]
    launch: Sequence[str] = ()
    demo: Sequence[str] = ()


CHAPTERS: Dict[str, Chapter] = {
    'slam': Chapter(
        'drive round turtlebot3_world, save the map, compare its pillars with the true ones',
        ('gmapping', 'turtlebot3_bringup', 'turtlebot3_description', 'turtlebot3_slam'),
        ('ros-noetic-gmapping', 'ros-noetic-turtlebot3-slam'),
        ('turtlebot3_slam', 'turtlebot3_slam.launch', 'model:=burger', 'slam_methods:=gmapping')),
    'navigation': Chapter(
        'drive to goals on the map of slam, and compare with the true position',
        ('amcl', 'dwa_local_planner', 'map_server', 'move_base', 'turtlebot3_bringup',
         'turtlebot3_description', 'turtlebot3_navigation'),
        ('ros-noetic-dwa-local-planner', 'ros-noetic-turtlebot3-navigation'),
        ('turtlebot3_navigation', 'turtlebot3_navigation.launch', 'model:=burger')),
    'dqn': Chapter(
        'drive to goals in the environment of turtlebot3_dqn, without TensorFlow',
        ('gazebo_msgs', 'tf', 'turtlebot3_dqn', 'turtlebot3_gazebo'),
        ('ros-noetic-gazebo-msgs', 'ros-noetic-tf'),
        demo=('world:=turtlebot3_stage_1', 'x_pos:=0', 'y_pos:=0')),
    'autorace': Chapter(
        'follow the lane of AutoRace 2020 by the camera, round two corners',
        ('image_proc', 'turtlebot3_autorace_camera', 'turtlebot3_autorace_detect',
         'turtlebot3_autorace_driving', 'turtlebot3_description', 'turtlebot3_gazebo'),
        ('ros-noetic-image-proc', 'ros-noetic-compressed-image-transport'),
        ('{here}/autorace.launch',),
        ('world:=turtlebot3_autorace_2020', 'x_pos:=0.8', 'y_pos:=-1.747',
         'urdf:={turtlebot3_description}/urdf/turtlebot3_burger_for_autorace_2020.urdf.xacro')),
}
# what Debian has of these packages
DEBIAN = {'image_proc': 'ros-image-proc libimage-proc-dev', 'tf': 'libtf-dev python3-tf'}
# files without which a package is not complete: the second one of image_proc has this one
FILES = {'image_proc': 'nodelet_plugins.xml'}

# what the package of turtlebot3_world is in Gazebo, m: the centers and the radius of the pillars
PILLARS = [(x, y) for x in (-1.1, 0.0, 1.1) for y in (-1.1, 0.0, 1.1)]
PILLAR_RADIUS = 0.15
START = (-2.0, -0.5)
# free places on three sides of the pillars, with the heading in rad
GOALS = ((0.55, -1.7, 0.0), (1.7, 0.55, 1.57), (-0.55, 1.7, 3.14))
GOAL_RADIUS = 0.1       # m, how near the robot has to come
