"""The node in a simulation that the test drives."""
import math

POST_X, POST_Y, NEAR_M = 0.5, -0.15, 0.6


def path_to_the_post(simulation):
    """Return the poses of the robot until it is near the post, one in 0.1 s."""
    path = []

    def is_near():
        """The robot is near the post."""
        path.append(sim.pose())
        return math.hypot(path[-1].x - POST_X, path[-1].y - POST_Y) <= NEAR_M

    # small images and a short way take less time
    sim = simulation(launch=('my_robot_vision', 'my_robot_vision.launch'), lockstep='cmd_vel',
                     image_width=320, image_height=240, x_pos=-1.0)
    sim.wait_until(is_near, timeout_s=30)
    return path


def test_the_robot_drives_to_the_post_on_the_same_path_each_time(simulation):
    assert path_to_the_post(simulation) == path_to_the_post(simulation)
