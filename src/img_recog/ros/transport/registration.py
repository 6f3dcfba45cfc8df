"""Registering with a new master: rospy registers only once; no new node would find this one."""
from typing import Any, Callable, NamedTuple

import rospy
from rospy.impl import registration

from img_recog.ros.transport.switch import is_plain


class Registered(NamedTuple):
    """How much was registered."""

    topics: int
    services: int


def is_watched() -> bool:
    """Return whether nodes notice a new master: not with plain rospy."""
    return not is_plain('registration')


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
