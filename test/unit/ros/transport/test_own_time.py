"""Time in a node that publishes /clock."""
import genpy
import pytest
import rospy

from img_recog.ros.transport import own_time


@pytest.fixture(autouse=True)
def restored_time():
    """Restore the clock of rospy after the test, and read the switch again."""
    own_time.follows_clock_topic.cache_clear()
    was_initialized = rospy.rostime.is_rostime_initialized()
    rospy.rostime.set_rostime_initialized(True)
    yield
    own_time.follows_clock_topic.cache_clear()
    rospy.rostime.switch_to_wallclock()
    rospy.rostime.set_rostime_initialized(was_initialized)


def test_the_node_has_the_time_that_it_sets(fast):
    assert not own_time.follows_clock_topic()
    for seconds in (5, 9, 2):
        own_time.set_time(genpy.Time(seconds, 7))
        assert rospy.Time.now() == rospy.Time(seconds, 7)


def test_with_plain_rospy_the_time_comes_from_the_topic(monkeypatch):
    monkeypatch.setenv('IMG_RECOG_PLAIN_ROSPY', '1')
    assert own_time.follows_clock_topic()
    own_time.set_time(genpy.Time(5, 0))
    assert rospy.Time.now() > rospy.Time(1000000000)
