"""The processes of subscribers, by the answers of master and nodes."""
import os
import socket

import pytest

from img_recog.ros.master import local_subscribers
from img_recog_testing.waiting import wait_for
from img_recog_testing.xmlrpc_server import XmlRpcServer

NODE, OTHER = '/gazebo', '/detector'


@pytest.fixture
def subscribed(monkeypatch):
    """What makes a LocalSubscribers of which one node, at an address, is a subscriber."""
    def start(uri):
        master = XmlRpcServer(
            getSystemState=lambda *_: [1, '', [[['/scan', [NODE]]], [['/scan', [OTHER]]], []]],
            lookupNode=lambda *_: [1, '', uri])
        servers.append(master)
        monkeypatch.setattr(local_subscribers, '_PERIOD_S', 0.02)
        monkeypatch.setattr(local_subscribers.rospy, 'get_name', lambda: NODE)
        monkeypatch.setattr(local_subscribers.rospy, 'is_shutdown', lambda: has_ended)
        monkeypatch.setattr(local_subscribers.rosgraph, 'get_master_uri', lambda: master.uri)
        return local_subscribers.LocalSubscribers()
    servers, has_ended = [], []
    yield start
    has_ended.append(True)
    for server in servers:
        server.stop()


def test_a_node_that_was_slow_to_answer_is_asked_again(subscribed):
    with socket.socket() as silent:         # takes connections, and never answers
        silent.bind(('127.0.0.1', 0))
        silent.listen()
        port = silent.getsockname()[1]
        found = subscribed('http://localhost:{}/'.format(port))
        wait_for(lambda: found.pids == {OTHER: 0}, lambda: found.pids)
    node = XmlRpcServer(port=port, getPid=lambda *_: [1, '', os.getpid()])
    try:
        wait_for(lambda: found.pids == {OTHER: os.getpid()}, lambda: found.pids)
    finally:
        node.stop()


def test_a_node_on_another_computer_has_no_process_here(subscribed):
    found = subscribed('http://192.0.2.1:11311/')
    wait_for(lambda: found.pids == {OTHER: 0}, lambda: found.pids)
