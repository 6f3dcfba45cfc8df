"""Reading the area of one color, as doc/colors.md shows; the parameters of color_extract."""
import re
import shlex
import sys

from img_recog_helpers.pages import read

PAGE = read('doc/colors.md')
PUBLISHER = """
import rospy
from sensor_msgs.msg import PointCloud
from std_msgs.msg import Header
from img_recog.conversions import color_detection_msgs
rospy.init_node('publisher')
publisher = rospy.Publisher('color_detection', PointCloud, queue_size=1, latch=True)
publisher.publish(color_detection_msgs.to_msg(
    ['blue', 'red'], [1600, 25], [(1, 2), (3, 4)], Header()))
rospy.spin()
"""


def test_areas_are_read_as_the_page_shows(shared_ros):
    shared_ros.start(sys.executable, '-c', PUBLISHER)
    code, = re.findall('```python\n(.*?)```', PAGE, re.DOTALL)
    assert len(code.splitlines()) == 5
    assert shared_ros.run(sys.executable, '-c', code).endswith('1600.0\n')
    found = [shared_ros.run(*shlex.split(line), '-n', '1').split()[0]
             for line in re.findall('/run shell (rostopic echo .*)', PAGE)]
    assert found == ['1600.0', '25.0']


def test_a_new_start_keeps_no_parameter_of_the_file_before(shared_ros, tmp_path):
    path = tmp_path / 'colors.yaml'
    for lost_s, text in (0.7, 'min_blob_size: 77\n'), (0.6, ''):
        path.write_text('{}stop_when_lost: {}\n'.format(text, lost_s))
        launch = shared_ros.roslaunch('img_recog', 'recognition.launch', 'colors:={}'.format(path))
        shared_ros.node_pid('/color_extract')
        found = shared_ros.parameter('/color_extract')
        assert found['stop_when_lost'] == lost_s
        assert (found.get('min_blob_size') == 77) == bool(text), found
        launch.interrupt()
