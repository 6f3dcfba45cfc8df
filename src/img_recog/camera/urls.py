"""URLs of videos and streams: which there are, and how they may stand in a log."""
import re
from urllib.parse import urlsplit

SCHEMES = ('http', 'https', 'rtmp', 'rtsp', 'rtsps')

# The authority ends at the first of /?# and its user at the last @ within, as ffmpeg has it. A
# password with one of these in it makes what should be a port none: there up to the last @ of all.
_USER = re.compile(r'(?<=://)(?:[^/?#]*@|[^/?#]*:(?!\d*(?:[/?#]|$)).*@)')
_QUERY = re.compile(r'(?<=[?#]).*')


def split(url: str) -> tuple:
    """Return the scheme of a URL in small letters, and the URL with that scheme.

    ffmpeg knows schemes in small letters only; they mean the same (RFC 3986, 3.1).
    """
    scheme, separator, rest = url.partition('://')
    return scheme.lower(), scheme.lower() + separator + rest


def ends_with(url: str, extensions: tuple) -> bool:
    """Return whether the path in a URL ends with one of these, whatever query follows."""
    return urlsplit(url).path.lower().endswith(extensions)


def redacted(name: str) -> str:
    """Return what `video_device` names as it may stand in a log: without user and query.

    Either may hold a password.
    """
    return _QUERY.sub('...', _USER.sub('', name)) if '://' in name else name
