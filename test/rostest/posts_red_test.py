#!/usr/bin/env python3
"""A camera on the robot and the article's colors: away from red until it is small."""
import unittest


from img_recog_helpers.driven import START, Robot, place, yaw
from img_recog_helpers.recording import main, wait_for


class PostsRedTest(unittest.TestCase):
    """The robot starts with a red post ahead."""

    def test_away_from_red_until_it_is_small(self):
        robot = Robot()
        robot.begin_again()

        def small():
            """Return the stamps of the images with less red than the limit."""
            return [stamp_s for stamp_s, area in robot.areas('red') if area <= 1000]
        wait_for(small, lambda: 'less red: {}'.format(robot.areas('red')[-3:]))
        end_s = small()[0]
        areas = [area for stamp_s, area in robot.areas('red') if stamp_s < end_s]
        self.assertGreater(len(areas), 5)
        self.assertTrue(4000 < areas[0] < 7000, areas[0])
        self.assertTrue(all(after < before + 100 for before, after in zip(areas, areas[1:])),
                        areas)
        wait_for(lambda: robot.odometry.messages[-1].header.stamp.to_sec() > end_s, 'odometry')
        driven = [msg for msg in robot.odometry.messages if msg.header.stamp.to_sec() <= end_s]
        places = [place(msg)[0] for msg in driven]
        self.assertAlmostEqual(START[0], places[0], delta=0.05)
        # the post is at -3.4; it has 1000 pixels at 3.2 m
        self.assertTrue(-0.9 < places[-1] < 0.3, places[-1])
        self.assertTrue(all(after > before - 0.002 for before, after in zip(places, places[1:])))
        self.assertTrue(all(abs(abs(yaw(msg)) - 3.14159) < 0.2 for msg in driven))
        self.assertEqual((-10.0, 0.0), (robot.commands.messages[0].linear.x,
                                        robot.commands.messages[0].angular.z))


if __name__ == '__main__':
    main(PostsRedTest)
