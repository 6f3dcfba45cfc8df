"""What is known of bags before one is opened, and all that loads before it is known to be one."""
DEFAULT_TOPICS = ('/usb_cam/image_raw', '/usb_cam/image_raw/compressed')
_MAGIC = b'#ROSBAG'


def is_bag(path: str) -> bool:
    """Return whether a file is a bag, by its first bytes or, if it has none of use, its name."""
    with open(path, 'rb') as file:
        return file.read(len(_MAGIC)) == _MAGIC or path.endswith('.bag')
