"""Which nodes and topics a picture shows."""
import pytest

from img_recog.graph.reader import Edge, System, clusters_of, visible

CAMERA = Edge('/usb_cam', '/usb_cam/image_raw', True)
IMAGES = Edge('/color_extract', '/usb_cam/image_raw', False)
COMMANDS = Edge('/color_extract', '/cmd_vel', True)
ZEROS = Edge('/teleop', '/cmd_vel', True)
DRIVEN = Edge('/gazebo', '/cmd_vel', False)
ODOM = Edge('/gazebo', '/odom', True)
LOGS = [Edge('/gazebo', '/rosout', True), Edge('/rosout', '/rosout', False)]
PARAMETERS = [Edge(node, '/usb_cam/' + topic, is_published)
              for topic in ('parameter_descriptions', 'parameter_updates')
              for node, is_published in (('/usb_cam', True), ('/tuner', False))]


def system(*edges, **fields):
    return System(frozenset(edge.node for edge in edges), frozenset(edges), **fields)


def test_a_chain_is_shown_as_it_is():
    chain = system(CAMERA, IMAGES, COMMANDS, DRIVEN, rates_hz={CAMERA: 30.0})
    assert visible(chain) == chain
    assert chain.topics == {'/usb_cam/image_raw', '/cmd_vel'}


@pytest.mark.parametrize('hidden, is_leaf', [
    ([ODOM], True),                                         # used once
    ([ODOM, Edge('/other', '/odom', True)], True),          # nobody subscribes
    (LOGS, False), (PARAMETERS, False)])
def test_what_is_hidden_and_whether_as_a_leaf(hidden, is_leaf):
    chain = [CAMERA, IMAGES, COMMANDS, DRIVEN]
    assert visible(system(*chain, *hidden)).edges == set(chain)
    assert visible(system(*chain, *hidden), leaves=True).edges == {
        *chain, *(hidden if is_leaf else ())}


def test_two_publishers_without_a_subscriber_are_a_leaf_but_with_one_they_are_not():
    assert visible(system(COMMANDS, ZEROS)).edges == set()
    assert visible(system(COMMANDS, ZEROS, DRIVEN)).edges == {COMMANDS, ZEROS, DRIVEN}


def test_nodes_without_an_edge_are_shown_and_debugging_nodes_are_not():
    assert visible(system(CAMERA, *LOGS)).nodes == {'/usb_cam', '/gazebo'}


def test_one_topic_of_a_pair_of_parameters_is_shown():
    assert visible(system(*PARAMETERS[:2])).edges == set(PARAMETERS[:2])


def test_dead_nodes_are_hidden_with_their_edges():
    dead = system(COMMANDS, ZEROS, DRIVEN, dead=frozenset(['/teleop']))
    assert visible(dead).edges == {COMMANDS, DRIVEN}
    assert visible(dead).nodes == {'/color_extract', '/gazebo'}


@pytest.mark.parametrize('name, clusters', [('/cmd_vel', ()), ('/a/b/c/d', ('/a', '/a/b'))])
def test_namespaces_of_a_name(name, clusters):
    assert clusters_of(name) == clusters
