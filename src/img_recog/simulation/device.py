"""What observes a robot."""
import abc
from typing import Any


class Device(abc.ABC):
    """Sees something of a robot once in a period."""

    @abc.abstractmethod
    def observe(self) -> Any:
        """Return what is seen now."""

    def restart(self) -> None:
        """Forget what was before; nothing for a device whose values hang on nothing before."""
