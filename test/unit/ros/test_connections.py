"""What is missing until a node hears of a topic, by a master and nodes of the test."""
import pytest

from img_recog.ros.connections import Connections
from img_recog_helpers.xmlrpc_server import XmlRpcServer

DEAD = 'http://127.0.0.1:9/'


@pytest.fixture
def system():
    """What the master knows, and what nodes say; /dead does not answer."""
    state = {'publishers': {}, 'subscribers': {}, 'sent': []}
    state['type'] = 'std_msgs/String'
    roscpp = XmlRpcServer(getBusInfo=lambda caller: [1, 'bus info', state['sent']])
    rospy = XmlRpcServer(getBusInfo=lambda caller: [1, 'bus info', [
        [1, roscpp.uri, 'i', 'TCPROS', '/image', True, ''], *state['sent']]])
    uris = {'/dead': DEAD, '/camera': roscpp.uri, '/node': rospy.uri, '/me': rospy.uri}
    master = XmlRpcServer(
        getSystemState=lambda caller: [1, '', [list(state['publishers'].items()),
                                               list(state['subscribers'].items()), []]],
        getTopicTypes=lambda caller: [1, '', [['/answer', state['type']]]],
        lookupNode=lambda caller, node: [1, '', uris[node]] if node in uris else [-1, '', ''])
    connections = Connections(master.uri, '/me')
    state['missing'] = lambda: connections.missing({'/answer': 'std_msgs/String'})
    state['shared'], state['own'] = connections.shared, connections.own
    state['uris'] = lambda: connections.uris == {'/node': rospy.uri}
    yield state
    for server in (roscpp, rospy, master):
        server.stop()


def test_a_publisher_that_answers(system):
    assert system['missing']() == ['a publisher of /answer']
    system['publishers'] = {'/answer': ['/dead', '/unknown']}
    assert system['missing']() == ['a publisher of /answer']
    system['publishers'] = {'/answer': ['/dead', '/node']}
    assert system['missing']() == ['a connection of /me to /answer of /node']
    assert not system['uris']()
    system['sent'] = [[2, '/me', 'o', 'TCPROS', '/answer', True, '']]
    assert system['missing']() == [] and system['uris']()


def test_a_topic_with_a_similar_name(system):
    system['publishers'] = {'/answr': ['/dead'], '/answers': ['/me'], '/image': ['/me']}
    assert system['missing']() == ['a publisher of /answer (did you mean /answr?)']
    assert system['own']() == {'/answers', '/image'}


def test_what_the_publisher_subscribes_to(system):
    system['publishers'] = {'/answer': ['/node'], '/image': ['/camera', '/dead'], '/other': []}
    system['subscribers'] = {'/image': ['/node', '/viewer'], '/other': ['/node']}
    system['sent'] = [[2, '/me', 'o', 'TCPROS', '/answer', True, ''],
                      [3, '/viewer', 'o', 'TCPROS', '/image', True, '']]
    assert system['missing']() == ['a connection of /node to /image of /camera']
    system['sent'].append([4, '/node', 'o', 'TCPROS', '/image', True, ''])
    assert system['missing']() == []


def test_what_the_publisher_hears_through_others(system):
    system['publishers'] = {'/answer': ['/node'], '/color': ['/camera'], '/image': ['/me']}
    system['subscribers'] = {'/color': ['/node'], '/image': ['/camera']}
    sent = system['sent']
    sent += [[2, '/me', 'o', 'TCPROS', '/answer', True, ''],
             [3, '/node', 'o', 'TCPROS', '/color', True, '']]
    assert system['missing']() == ['a connection of /camera to /image of /me']
    sent.append([4, '/camera', 'o', 'TCPROS', '/image', True, ''])
    assert system['missing']() == []
    del system['publishers']['/color']      # it comes back, and has not advertised yet
    assert system['missing']() == ['a publisher of /color']


def test_a_publisher_of_another_type(system):
    system['publishers'] = {'/answer': ['/node']}
    system['type'] = 'std_msgs/Header'
    assert system['missing']() == ['a connection of /me to /answer of /node, which publishes '
                                   'std_msgs/Header, not std_msgs/String']


def test_what_others_publish_too(system):
    system['publishers'] = {'/image': ['/bag', '/me'], '/mine': ['/me'], '/theirs': ['/bag', '/b'],
                            '/tf': ['/bag', '/me']}
    assert system['shared']() == [('/image', ['/bag'])]
