"""Recognition goes on with hostile parameters, images and subscribers."""
import sys

from rosgraph_msgs.msg import Log

from img_recog_helpers import wire
from img_recog_helpers.waiting import DEADLINE_S

FORGED = 'x\n[FATAL] forged'
HOSTILE_IMAGES = '''
import numpy, rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image
count = [0]

def received(_):
    count[0] += 1
rospy.init_node('hostile', anonymous=True)
rospy.Subscriber('/cmd_vel', Twist, received)
images = rospy.Publisher('/usb_cam/image_raw', Image, queue_size=1)
blue = numpy.zeros((48, 64, 3), numpy.uint8)
blue[:] = (255, 0, 0)
good = Image(height=48, width=64, step=192, encoding='bgr8', data=blue.tobytes())
bad = Image(height=48, width=64, step=192, data=good.data, encoding=ENCODING)
bad.header.frame_id = ENCODING
turn = 0
while count[0] < 20 and not rospy.is_shutdown():
    images.publish(bad if turn % 4 == 0 else good)
    turn += 1
    rospy.sleep(0.1)
print('{} commands'.format(count[0]))
'''


def test_recognition_goes_on(shared_ros):
    shared_ros.set_parameters('/color_extract', {FORGED: 1, 'blue_image_topi': 'x' * (8 << 20)})
    node = shared_ros.start_node('color_img_recog.py')
    node.wait_output(r'parameter /color_extract/x\\n\[FATAL\] forged is unknown')
    node.wait_output('parameter /color_extract/blue_image_topi is unknown')
    # a subscriber that never reads
    silent = wire.Subscription(shared_ros.master_uri, '/color_extract', '/rosout', Log,
                               DEADLINE_S, buffer_bytes=1)       # the minimum
    shared_ros.stack.callback(silent.close)
    hostile = shared_ros.start(sys.executable, '-c', HOSTILE_IMAGES.replace(
        'ENCODING', repr(FORGED + '\x1b[2J') + ' + "x" * (8 << 20)'))
    hostile.wait_output('commands')
    node.wait_output(r'frame skipped: .*encoding .x\\n\[FATAL\] forged\\x1b\[2J')
    assert node.interrupt() == 0
    assert '\n[FATAL]' not in node.output and '\x1b' not in node.output.replace('\x1b[33m', '') \
        .replace('\x1b[0m', '')
    assert max(map(len, node.output.splitlines())) < 2200


def test_a_node_runs_without_a_log_folder(shared_ros, tmp_path):
    (tmp_path / 'file').write_text('')
    env = dict(shared_ros.env, ROS_HOME=str(tmp_path / 'file' / 'home'))
    node = shared_ros.start_node('usb_cam_node.py', '_video_device:=synthetic', env=env)
    node.wait_output('camera: synthetic scene')
    assert node.interrupt() == 0
    assert node.output.count('cannot create log directory') == 1 and 'Traceback' not in node.output
