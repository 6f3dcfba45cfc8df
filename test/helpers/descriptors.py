"""The files that this process holds open."""
import os


def times_open(path):
    """Return how many file descriptors of this process are of this file.

    A count of all descriptors would change whenever another thread opens or closes one.
    """
    links = ('/proc/self/fd/' + number for number in os.listdir('/proc/self/fd'))
    return sum(os.path.realpath(link) == os.path.realpath(str(path)) for link in links)
