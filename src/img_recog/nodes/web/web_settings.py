"""The parameters of the page that are not those of the teleoperation."""
from dataclasses import dataclass

from img_recog.settings import Settings, between, not_empty, setting


@dataclass(frozen=True)
class WebSettings(Settings):
    """Where the page is served.

    web_host: the address to listen on; the default is this computer alone. Anyone who reaches it
    and has the token drives the robot; nothing is encrypted.
    web_port: the first port to try; if it is taken, the next free one of the ten after it.
    """

    web_host: str = setting('127.0.0.1', not_empty())
    web_port: int = setting(8080, between(1, 65535))
