"""Topics of images."""
import rospy


def topic_beside(raw_topic: str) -> str:
    """Return the topic of the compressed images for a raw topic, after remapping."""
    return rospy.resolve_name(raw_topic) + '/compressed'
