"""The system as the master and the nodes tell it, by real XML-RPC on the loopback."""
import threading
import xmlrpc.client

import pytest

from img_recog.errors import UserError
from img_recog.graph.reader import Edge, SystemReader, completed, counts_in, new_messages
from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.xmlrpc_server import XmlRpcServer

SENT, GOT = Edge('/cam', '/image', True), Edge('/eye', '/image', False)
MORE = Edge('/other', '/image', True)


@pytest.fixture
def serve():
    servers = []

    def start(**methods):
        servers.append(XmlRpcServer(**methods))
        return servers[-1]
    yield start
    for server in servers:
        server.stop()


@pytest.fixture
def timeout_s():
    """The time limit of a call; a busy machine needs longer than the usual one."""
    return DEADLINE_S


@pytest.fixture
def read(serve, monkeypatch, timeout_s, clock):
    """A function that reads the system of nodes with the given answers of getBusStats."""
    uris = {}

    def lookup(_, node):
        return [1, '', uris[node]] if node in uris else [-1, 'unknown node', '']
    state = [[['/image', ['/cam']]], [['/image', ['/eye']]], [['/cam/set_camera_info', ['/cam']]]]
    publishers = state[0][0][1]
    monkeypatch.setenv('ROS_MASTER_URI', serve(
        getSystemState=lambda _: [1, '', state], lookupNode=lookup).uri)
    system_reader = SystemReader(clock, timeout_s)

    def call(time_s, **answers):
        clock.now_s = time_s
        for node, answer in answers.items():
            if node == 'other':
                publishers.append('/other')
            if answer is None:
                continue
            uris['/' + node] = serve(getBusStats=answer).uri
        return system_reader.read()
    return call


def of_rospy(sent):
    return lambda _: [1, '', [[['/image', 7, [[3, 4000, sent(), True]]]], [], []]]


def of_roscpp(got):
    return lambda _: [[], [['/image', [[1, 4000, got(), 0, 0]]]]]


def test_nodes_topics_and_rates(read):
    counts = [0]
    first = read(10.0, cam=of_rospy(lambda: counts[0]), eye=of_roscpp(lambda: counts[0] // 2))
    assert first.nodes == {'/cam', '/eye'} and first.edges == {SENT, GOT}
    assert first.dead == set() and first.rates_hz == {}
    counts[0] = 60
    assert read(12.0).rates_hz == {SENT: 30.0, GOT: 15.0}
    assert read(14.0).rates_hz == {SENT: 0.0, GOT: 0.0}


def test_a_subscriber_that_tells_of_one_connection_of_several(read):
    counts = [0]
    read(0.0, cam=of_rospy(lambda: counts[0]), other=of_rospy(lambda: counts[0] // 2),
         eye=of_roscpp(lambda: counts[0] // 2))
    counts[0] = 60
    assert read(2.0).rates_hz == {SENT: 30.0, MORE: 15.0, GOT: 45.0}


def test_a_publisher_that_does_not_answer_has_no_connection(read):
    counts = [0]
    read(0.0, cam=of_rospy(lambda: counts[0]), eye=of_roscpp(lambda: counts[0]))
    counts[0] = 60
    system = read(2.0, other=None)
    assert system.rates_hz == {SENT: 30.0, GOT: 30.0} and system.dead == {'/other'}


@pytest.mark.parametrize('timeout_s', [0.05])
def test_a_node_that_does_not_answer_is_dead(read):
    hold = threading.Event()
    system = read(0.0, cam=lambda _: hold.wait(10))
    hold.set()
    assert system.dead == {'/cam', '/eye'}      # one is stopped, one is unknown to the master


def test_a_node_that_registers_again_is_found(read):
    assert read(0.0, cam=of_rospy(lambda: 0)).dead == {'/eye'}
    assert read(1.0, eye=of_roscpp(lambda: 0)).dead == set()


def test_a_count_that_does_not_fit_is_taken_from_the_other_side(read):
    def overflow(_):
        raise xmlrpc.client.Fault(1, 'int exceeds XML-RPC limits')
    counts = [0]
    read(0.0, cam=overflow, eye=of_roscpp(lambda: counts[0]))
    counts[0] = 20
    system = read(1.0)
    assert system.rates_hz == {SENT: 20.0, GOT: 20.0} and system.dead == set()


@pytest.mark.parametrize('answer', [lambda _: 'hello', lambda _: [0, 'busy', 0],
                                    lambda _: [1, '', 5]])
def test_a_master_that_makes_no_sense(serve, monkeypatch, answer):
    monkeypatch.setenv('ROS_MASTER_URI', serve(getSystemState=answer).uri)
    with pytest.raises(UserError, match='^no master answers at .*; start roscore'):
        SystemReader(timeout_s=DEADLINE_S).read()


def test_a_master_that_does_not_answer(serve, monkeypatch):
    hold = threading.Event()
    monkeypatch.setenv('ROS_MASTER_URI', serve(getSystemState=lambda _: hold.wait(10)).uri)
    with pytest.raises(UserError, match='^no master answers at .*: timed out; start roscore'):
        SystemReader(timeout_s=0.05).read()
    hold.set()


@pytest.mark.parametrize('uri', ['', 'ftp://localhost:11311', 'http://localhost:port'])
def test_a_uri_that_is_no_address(monkeypatch, uri):
    monkeypatch.setenv('ROS_MASTER_URI', uri)
    with pytest.raises(UserError) as refused:
        SystemReader()
    assert str(refused.value) == (
        "ROS_MASTER_URI is '{}', expected http://HOST:PORT; set it to the address of the master, "
        'like http://localhost:11311'.format(uri))


def test_an_answer_that_makes_no_sense(read):
    assert read(0.0, cam=lambda _: 'hello', eye=lambda _: [1, '', 5]).dead == {'/cam', '/eye'}


@pytest.mark.parametrize('edge, before, now, count', [
    (SENT, {1: 5}, {1: 9, 2: 3}, 4), (GOT, {}, {1: 3}, None), (GOT, {1: 9}, {1: 3}, None),
    (SENT, {1: 5}, {}, None)])
def test_new_messages_where_connections_come_and_go(edge, before, now, count):
    assert new_messages(edge, before, now) == count


def test_the_fields_of_rospy():
    rospy_stats = [1, '', [[['/image', 7, [[3, 4000, 12, True]]]],
                           [['/odom', [[4, 900, 8, -1, True]]]], []]]
    assert counts_in('/cam', rospy_stats) == {
        SENT: {3: 12}, Edge('/cam', '/odom', False): {4: 8}}


@pytest.mark.parametrize('edges, known, expected', [
    ([SENT, GOT], {SENT: 30.0}, {SENT: 30.0, GOT: 30.0}),
    ([SENT, MORE, GOT], {GOT: 20.0}, {GOT: 20.0}),
    ([SENT, MORE, GOT], {SENT: 20.0}, {SENT: 20.0}),
    ([SENT, MORE, GOT], {SENT: 20.0, MORE: 1.0}, {SENT: 20.0, MORE: 1.0, GOT: 21.0}),
    ([GOT], {}, {})])
def test_rates_that_follow_from_others(edges, known, expected):
    assert completed(edges, known) == expected
