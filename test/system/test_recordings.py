"""What the demo records is replayed, from its first message on."""
import xmlrpc.client

import cv2
import numpy as np
import pytest
import rosbag

from img_recog.processes.bag_recording import TOPICS
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.waiting import wait_for

IMAGES = '/usb_cam/image_raw/compressed'
SECOND_NS = 10 ** 9


@pytest.fixture(scope='module')
def sources(tmp_path_factory):
    """The path of a folder with images, and of a video of 10 s."""
    folder = tmp_path_factory.mktemp('sources')
    (folder / 'images').mkdir()
    image = np.zeros((48, 64, 3), np.uint8)
    for number in range(3):
        cv2.imwrite(str(folder / 'images' / '{}.png'.format(number)), image)
    video = str(folder / 'video.avi')
    writer = cv2.VideoWriter(video, cv2.VideoWriter_fourcc(*'MJPG'), 10, (64, 48))
    for number in range(100):
        writer.write(image)
    writer.release()
    return {'images': str(folder / 'images'), 'video': video}


def is_recorded(ros, topic):
    """Return whether a publisher of a topic has a connection to the recorder."""
    master = ros.master()
    for node in dict(master.getSystemState('/test')[2][0]).get(topic, ()):
        with xmlrpc.client.ServerProxy(master.lookupNode('/test', node)[2]) as server:
            if any(info[1] == '/record' and info[4] == topic
                   for info in server.getBusInfo('/test')[2]):
                return True
    return False


@pytest.mark.parametrize('robot, arguments', [
    ('', ['camera:=synthetic']), ('', ['camera:=robot']), ('', ['camera:={video}']),
    ('', ['camera:={images}']), ('/tb3_1', ['camera:=robot', 'robots:=2']),
    ('/tb3_1', ['camera:={video}', 'robots:=2'])])
def test_each_recording_of_the_demo_is_replayed(ros, tmp_path, sources, robot, arguments):
    demo = ros.demo('world:=empty', 'framerate:=10', 'record:={}/demo'.format(tmp_path),
                    *(each.format(**sources) for each in arguments))
    ros.node_pid('/record')
    infos = Echo(ros, robot + '/usb_cam/camera_info/header/stamp')
    wait_for(lambda: is_recorded(ros, robot + IMAGES), 'the recorder of ' + robot + IMAGES)
    infos.wait_more(10)
    assert demo.interrupt() == 0, demo.output
    path = str(tmp_path / 'demo.bag')
    with rosbag.Bag(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        stamps = [msg.header.stamp.to_nsec() for _, msg, _ in bag.read_messages(robot + IMAGES)]
    assert [name for name in topics if not name.startswith('/')] == []
    if not robot:
        assert set(topics) <= {'/' + name.lstrip('/') for name in TOPICS}
    # the clock of the simulator, whose own camera alone has an image of the time 0
    assert stamps and ('camera:=robot' in arguments or stamps[0] >= SECOND_NS // 100), stamps
    replay = ros.start_node('replay.py', path, '--topic', robot + IMAGES, cwd=str(tmp_path))
    assert replay.wait() == 0, replay.output
    assert '{} frames, '.format(len(stamps)) in replay.output, replay.output


@pytest.mark.parametrize('is_paused', [False, True])
def test_a_recording_goes_on_after_a_reset_and_the_last_part_is_replayed(ros, tmp_path, is_paused):
    demo = ros.demo('world:=empty', 'framerate:=10', 'camera:=robot',
                    'record:={}/demo'.format(tmp_path))
    ros.node_pid('/record')
    stamps = Echo(ros, '/usb_cam/camera_info/header/stamp')
    stamps.wait_more(20)
    services = ServiceCalls(ros)
    for service in (['pause_physics'] * is_paused + ['reset_simulation']
                    + ['unpause_physics'] * is_paused):
        services.call('/gazebo/' + service, {})
    stamps.wait(lambda stamp: stamp < SECOND_NS, 'an image after the reset')
    stamps.wait(lambda stamp: stamp > SECOND_NS, 'a second of images after the reset')
    services.close()
    assert demo.interrupt() == 0, demo.output
    assert '(record) has ended' not in demo.output
    replay = ros.start_node('replay.py', str(tmp_path / 'demo.bag'), cwd=str(tmp_path))
    assert replay.wait() == 0, replay.output
    assert ' messages of {} before the last restart are left out'.format(
        IMAGES) in replay.output, replay.output


def test_a_camera_waits_for_the_clock(ros, sources):
    ros.start_master()
    ros.set_parameters('/use_sim_time', True)
    camera = ros.start_node('usb_cam_node.py', '_video_device:=' + sources['video'])
    stamps = Echo(ros, '/usb_cam/camera_info/header/stamp')
    camera.wait_output('no time on /clock yet: start the simulator')
    assert stamps.rows == []
    ros.start('rostopic', 'pub', '-r', '10', '/clock', 'rosgraph_msgs/Clock', 'clock: {secs: 7}')
    stamps.wait_more(2)
    assert [row[0] for row in stamps.rows[:2]] == [7 * SECOND_NS, 7 * SECOND_NS + 1]
