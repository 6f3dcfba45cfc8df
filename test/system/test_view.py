"""The images of the simulation: when they are drawn, and their content."""
import pytest

from img_recog_helpers.process_table import cpu_s, descendants
from img_recog_helpers.simulator_tools import Echo, Images, drawing, drive, wait_standing
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


def test_the_view_is_drawn_only_with_subscribers(ros, simulate):
    node = simulate()
    clock = Echo(ros, '/clock/clock')
    since = clock.wait_more(50)[-1][0] * 1e-9
    assert descendants(node.pid) == {}
    images = Images(ros)
    image = images.wait(count=3)
    assert image['stamp'] > since
    clock.wait(lambda now: now * 1e-9 >= image['stamp'], 'the time of the image')
    assert (image['size'], image['encoding']) == ([640, 480, 1920], 'rgb8')
    assert image['frame'] == 'view'
    assert image['green']['share'] > 0.03
    assert image['white']['share'] > 0.0005
    assert image['wall']['share'] > 0.01
    stamps = [each['stamp'] for each in images.rows]
    assert stamps == sorted(set(stamps))

    images.close()
    drawer = drawing(node)
    wait_for(lambda: '/gazebo/view/image_raw' not in dict(
        ros.master().getSystemState('/test')[2][1]), 'no subscribers')

    def idle():
        before = cpu_s(drawer)
        clock.wait_more(50)
        return cpu_s(drawer) == before
    wait_for(idle, 'an end of the drawing')


def test_view_from_above_shows_the_robot_at_its_position(ros, simulate):
    simulate('_real_time_factor:=5', '_world:=empty')
    images = Images(ros)
    images.wait()
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait_more(1)
    x, y = images.wait(count=2)['dark']['middle']
    # 46 pixels per meter, the center is (0.8, 0), x points up
    assert (x, y) == pytest.approx((320 + 0.5 * 46.2, 240 + 2.8 * 46.2), abs=4)
    # in a circle around (-2, 0.5): however long the next command takes, it stays in the picture
    driving = drive(ros, 0.5, angular=0.5)
    place.wait(lambda x, y, z: y > 0.5, 'the robot to drive')
    driving.close()
    drive(ros, 0.0)
    x, y, _ = wait_standing(place)
    expected = pytest.approx((320 - y * 46.2, 240 + (0.8 - x) * 46.2), abs=4)
    # the newest image may be from before the halt
    images.wait(lambda image: image['dark']['middle'] and image['dark']['middle'] == expected)
