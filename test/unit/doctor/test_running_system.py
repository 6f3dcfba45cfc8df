"""Each thing that can be wrong with a running system is caused, and found."""
import re
import socket
import struct
import threading

import pytest
import yaml
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

from img_recog.doctor.doctor_job import check_running
from img_recog_helpers import expected
from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.xmlrpc_server import XmlRpcServer

TWIST, IMU = 'geometry_msgs/Twist', 'sensor_msgs/Imu'
CLOCK = {'/clock': 'rosgraph_msgs/Clock'}


@pytest.fixture
def findings(monkeypatch):
    """A function that starts a master with nodes and returns what is wrong.

    nodes: by their names, what they publish and subscribe to: dicts of types by topics; or the
    address of a node that does not answer. md5sum: of the definition that publishers of /imu
    have. imu_s: the stamp on it, where /clock is 10 s.
    """
    monkeypatch.setenv('LANG', 'C')
    servers = []

    def serve(**methods):
        servers.append(XmlRpcServer(**methods))
        return servers[-1].uri

    def publish(topic, md5sum, imu_s):
        is_clock = topic == '/clock'
        data = struct.pack('<II', 10, 0) if is_clock else struct.pack('<III', 7, imu_s, 0)
        port = publisher(Clock._md5sum if is_clock else md5sum, data)
        return [1, '', ['TCPROS', '127.0.0.1', port]]

    def call(nodes, is_sim_time=False, md5sum=Imu._md5sum, imu_s=9):
        uris = {name: parts if isinstance(parts, str) else serve(
            getPublications=lambda _, parts=parts: [1, '', list(map(list, parts[0].items()))],
            getSubscriptions=lambda _, parts=parts: [1, '', list(map(list, parts[1].items()))],
            requestTopic=lambda _, topic, __: publish(topic, md5sum, imu_s))
            for name, parts in nodes.items()}
        users = [{}, {}, {'/service': list(nodes)}]
        for name, parts in nodes.items():
            for kind in (0, 1) if not isinstance(parts, str) else ():
                for topic in parts[kind]:
                    users[kind].setdefault(topic, []).append(name)
        monkeypatch.setenv('ROS_MASTER_URI', serve(
            getSystemState=lambda _: [1, '', [list(map(list, each.items())) for each in users]],
            lookupNode=lambda _, node: [1, '', uris[node]],
            getParam=lambda *_: [1, '', is_sim_time]))
        return list(check_running())
    yield call
    for server in servers:
        server.stop()


def publisher(md5sum, data):
    """Answer one connection with a header, and a message of this data; return the port."""
    listener = socket.create_server(('127.0.0.1', 0))

    def answer():
        with listener, listener.accept()[0] as sock:
            sock.settimeout(DEADLINE_S)
            sock.recv(4096)
            field = 'md5sum={}'.format(md5sum).encode()
            length = len(field).to_bytes(4, 'little')
            sock.sendall((len(field) + 4).to_bytes(4, 'little') + length + field)
            sock.sendall(len(data).to_bytes(4, 'little') + data)
    threading.Thread(target=answer, daemon=True).start()
    return listener.getsockname()[1]


def test_a_healthy_system(findings):
    assert findings({'/sim': ({**CLOCK, '/imu': IMU}, {'/cmd_vel': '*'}),
                     '/eye': ({}, {'/imu': IMU, '/other': '*', **CLOCK}),
                     '/rosout': ({}, {})}, is_sim_time=True) == []


def test_no_master(monkeypatch):
    monkeypatch.setenv('LANG', 'C')
    monkeypatch.setenv('ROS_MASTER_URI', 'http://127.0.0.1:9')
    found, = check_running()
    assert found.problem == 'no master answers at http://127.0.0.1:9: Connection refused'
    assert 'roscore' in found.advice


def test_what_is_wrong(findings):
    def line(text):
        nodes = yaml.safe_load(text)
        found, = findings(**nodes.pop('options', {}), nodes=nodes)
        assert not found.is_note
        # systems say in different words why a name is no address, and name packages otherwise
        problem = re.sub('(?<=invalid:9: ).*', '...', found.problem)
        return '{}; {}'.format(problem, re.sub('[a-z0-9-]+(?=-no-such-)', '...', found.advice))
    expected.check_cases('refused/running_systems.txt', line)


def test_a_command_that_nobody_gives_is_a_note(findings):
    found, = findings({'/sim': ({}, {'/cmd_vel': TWIST})})
    assert found.is_note
