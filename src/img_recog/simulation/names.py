"""What the topics and frames of a robot are called."""
import dataclasses
from typing import Any, List, NamedTuple, TypeVar

_Settings = TypeVar('_Settings')


class Names(NamedTuple):
    """The namespace of the topics of a robot, and the prefix of its frames, both without slashes
    at the ends; '' for none.
    """

    namespace: str = ''
    frame_prefix: str = ''

    @property
    def words(self) -> str:
        """The robot in a sentence."""
        return 'robot ' + self.namespace if self.namespace else 'the robot'

    def topic(self, name: str) -> str:
        """Return the topic in the namespace, unless its name is global or there already.

        >>> Names('tb3_0').topic('scan'), Names('tb3_0').topic('/scan'), Names().topic('scan')
        ('tb3_0/scan', '/scan', 'scan')
        >>> Names('tb3_0').topic('tb3_0/scan')      # of a plugin with this <robotNamespace>
        'tb3_0/scan'
        """
        is_relative = self.namespace and not name.startswith(('/', self.namespace + '/'))
        return '/'.join((self.namespace, name)) if is_relative else name

    def frame(self, name: str) -> str:
        """Return the frame with the prefix, like tf::resolve.

        >>> Names('tb3_0', 'tb3_0').frame('odom')
        'tb3_0/odom'
        """
        return '/'.join((self.frame_prefix, name)) if self.frame_prefix else name

    def seen(self, settings: _Settings) -> _Settings:
        """Return settings with the names of topics and frames that others see.

        Those are the fields with names that end in _topic or _frame; an empty one stays so.
        """
        values = vars(settings)
        return dataclasses.replace(settings, **{  # type: ignore
            **{name: self.topic(values[name]) for name in topic_fields(settings)},
            **{name: self.frame(value) for name, value in values.items()
               if name.endswith('_frame') and value}})


def topic_fields(settings: Any) -> List[str]:
    """Return the names of the settings that are topics, without the empty ones."""
    return [name for name, value in vars(settings).items() if name.endswith('_topic') and value]
