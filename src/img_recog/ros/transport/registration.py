"""Registering with a new master: rospy registers only once; no new node would find this one."""
from typing import Any, Callable, Tuple

import rospy
from rospy.impl import registration


def register_again(call: Callable[..., Any]) -> Tuple[int, int]:
    """Register all topics and services of this node, and connect its subscribers.

    call: calls the master with the name of a method and its arguments without the caller's name,
    returns the value, and raises what fails. Returns how many topics and services there are.
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
    return len(publications) + len(subscriptions), len(offered)
