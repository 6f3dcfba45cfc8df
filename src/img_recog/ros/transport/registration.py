"""The calls of a node to the master: they never delay its end, and they can be repeated.

rospy calls the master without a time limit and registers only once: a node that is shut down while
the master does not answer would not end, and a new master would not know the node.
"""
import errno
import http.client
import socket
import threading
import weakref
import xmlrpc.client
from typing import Any, Callable, NamedTuple

import rosgraph
import rospy
from rospy.impl import registration

from img_recog.ros.transport.switch import is_plain

_CONNECT_TIMEOUT_S = 1.0            # of one attempt; a busy master gets more of them
_SHUTDOWN_TIMEOUT_S = 1.5           # for all that a node tells the master when it ends


class Registered(NamedTuple):
    """How much was registered."""

    topics: int
    services: int


def is_watched() -> bool:
    """Return whether nodes notice a new master: not with plain rospy."""
    return not is_plain('registration')


def limit_calls() -> None:
    """Have rospy's calls to the master end when the node is shut down.

    Call before init_node.
    """
    if is_watched():
        uri = rosgraph.get_master_uri()
        with rospy.core._xmlrpc_lock:
            rospy.core._xmlrpc_cache[uri] = rospy.core._LockedServerProxy(
                uri, transport=_Transport())


def end_calls() -> None:
    """Interrupt the calls that wait for the master; those that follow get a short time.

    For the begin of the shutdown, before rospy unregisters the node.
    """
    MasterConnection.is_ending.set()
    for connection in list(MasterConnection.all):
        connection.interrupt()


def register_again(call: Callable[..., Any]) -> Registered:
    """Register all topics and services of this node, and connect its subscribers.

    call: calls the master with the name of a method and its arguments without the caller's name,
    returns the value, and raises what fails.
    """
    topics, services = registration.get_topic_manager(), registration.get_service_manager()
    managers = [listener for listener in registration.get_registration_listeners().listeners
                if isinstance(listener, registration.RegManager)]
    uri = rospy.get_node_uri()
    publications, subscriptions = topics.get_publications(), topics.get_subscriptions()
    for name, message_type in publications:
        call('registerPublisher', name, message_type, uri)
    for name, message_type in subscriptions:
        publishers = call('registerSubscriber', name, message_type, uri)
        for manager in managers:
            manager.publisher_update(name, publishers)
    offered = services.get_services()
    for name, service_uri in offered:
        call('registerService', name, service_uri, uri)
    return Registered(len(publications) + len(subscriptions), len(offered))


class MasterConnection(http.client.HTTPConnection):
    """Waits for the master without limit until the node is shut down."""

    is_ending = threading.Event()
    all: 'weakref.WeakSet[MasterConnection]' = weakref.WeakSet()

    def connect(self) -> None:
        self.timeout = _CONNECT_TIMEOUT_S
        while True:
            try:
                super().connect()
                break
            except socket.timeout:      # its host drops the packets
                if self.is_ending.is_set():
                    raise _no_answer()
        self.all.add(self)
        self.sock.settimeout(_SHUTDOWN_TIMEOUT_S if self.is_ending.is_set() else None)

    def interrupt(self) -> None:
        """Have a thread that waits for an answer get an error; it then tries once more."""
        try:
            self.sock.shutdown(socket.SHUT_RDWR)
        except (AttributeError, OSError):       # closed meanwhile
            pass


class _Transport(xmlrpc.client.Transport):
    """Uses MasterConnection; a timeout is the error that rospy expects without a master."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        known_host, connection = self._connection or (None, None)
        if connection is None or host != known_host:
            connection = MasterConnection(host)
            self._connection = host, connection
        return connection

    def single_request(self, *args: Any, **kwargs: Any) -> Any:
        try:
            return super().single_request(*args, **kwargs)
        except socket.timeout:
            raise _no_answer()


def _no_answer() -> ConnectionRefusedError:
    return ConnectionRefusedError(errno.ECONNREFUSED, 'the master does not answer')
