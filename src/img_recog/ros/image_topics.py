"""Topics of images, as registered with the master."""
import os

import rosgraph
import rospy
from sensor_msgs.msg import CompressedImage, Image

from img_recog.errors import UserError, one_line, shortened

_KINDS = {kind._type: kind for kind in (Image, CompressedImage)}


class TopicError(UserError):
    """There is no such topic, or it does not carry images."""


def topic_beside(raw_topic: str) -> str:
    """Return the topic of the compressed images for a raw topic, after remapping."""
    return rospy.resolve_name(raw_topic) + '/compressed'


def kind_of(topic: str) -> type:
    """Return the message type of a topic, Image or CompressedImage; needs no node.

    topic: a resolved name.
    Raises TopicError with what is wrong and which topics have images.
    """
    try:
        published = dict(rosgraph.Master('/img_recog').getPublishedTopics(''))
    except (OSError, ValueError, rosgraph.MasterException) as error:
        raise TopicError('there is no file {0}, and no master at {1} to ask for a topic {0}: {2}; '
                         'start roscore or roslaunch first, or set ROS_MASTER_URI'.format(
                             topic, shortened(os.environ.get('ROS_MASTER_URI', '')),
                             one_line(error)))
    found = published.get(topic)
    if found in _KINDS:
        return _KINDS[found]
    images = ', '.join(sorted(name for name in published if published[name] in _KINDS))
    raise TopicError('{}; {}'.format(
        'there is no file {0} and nobody publishes a topic {0}'.format(topic) if found is None
        else 'topic {} has {}, no images'.format(topic, found),
        'topics with images are ' + images if images else 'no topic has images: start a camera'))
