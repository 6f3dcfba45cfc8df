"""URLs of videos and streams: their schemes, and how to log them without passwords."""
import re
from typing import Tuple
from urllib.parse import urlsplit

SCHEMES = ('http', 'https', 'rtmp', 'rtsp', 'rtsps')

# As in ffmpeg, the authority ends at the first of /?#, and the user at the last @ in it. If a
# password contains one of these, no port follows the colon: then the last @ of the URL counts.
_USER = re.compile(r'(?<=://)(?:[^/?#]*@|[^/?#]*:(?!\d*(?:[/?#]|$)).*@)')
_QUERY = re.compile(r'(?<=[?#]).*')


def split(url: str) -> Tuple[str, str]:
    """Return the scheme of a URL in lower case, and the URL with that scheme.

    ffmpeg accepts schemes in lower case only, although case does not matter (RFC 3986, 3.1).

    >>> split('RTSP://camera/Live')
    ('rtsp', 'rtsp://camera/Live')
    """
    scheme, separator, rest = url.partition('://')
    return scheme.lower(), scheme.lower() + separator + rest


def ends_with(url: str, extensions: Tuple[str, ...]) -> bool:
    """Return whether the path of a URL, without its query, ends with one of these.

    >>> ends_with('http://host/a.MP4?b=c.jpg', ('.mp4', '.avi'))
    True
    """
    return urlsplit(url).path.lower().endswith(extensions)


def redacted(name: str) -> str:
    """Return a `video_device` for the log: a URL without user and query, which may be secret.

    >>> redacted('rtsp://me:secret@camera/live?key=secret')
    'rtsp://camera/live?...'
    """
    return _QUERY.sub('...', _USER.sub('', name)) if '://' in name else name
