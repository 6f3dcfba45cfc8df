"""The tab with the states and rates of the nodes that publish /diagnostics."""
import time
from typing import Any, List

from diagnostic_msgs.msg import DiagnosticArray
from nicegui import ui

from img_recog.errors import shortened
from img_recog.nodes.web.measurements import Topic, number
from img_recog.nodes.web.page_elements import Visit
from img_recog.nodes.web.updates import MAX_STATES, Updates
from img_recog.ros.throttle import ThrottledWarning


def add(visit: Visit) -> None:
    """Add the elements of the tab."""
    with ui.element('section').classes('card table-box'):
        with ui.element('table').classes('plain'):
            with ui.element('thead'), ui.element('tr'):
                for key in ('node', 'state', 'rates'):
                    with ui.element('th').props('scope=col'):
                        ui.label(visit.texts(key))
            ui.element('tbody').props('data-nodes')


def topics(updates: Updates) -> List[Topic]:
    """Return the topic whose statuses are put into `updates`."""
    warn = ThrottledWarning()

    def diagnosed(msg: DiagnosticArray) -> None:
        for status in msg.status:
            is_known = updates.set('node ' + status.name, {
                'time_s': number(time.monotonic()),
                'name': shortened(status.name), 'level': _level(status.level),
                'message': shortened(status.message),
                'values': [[shortened(each.key), shortened(each.value)]
                           for each in status.values]})
            if not is_known:
                warn('more than %d names on /diagnostics: the others are not shown', MAX_STATES)
                return
    return [('/diagnostics', DiagnosticArray, diagnosed)]


def _level(level: Any) -> int:
    """Return the level of a diagnostic status, which is a byte in Python 3."""
    return level[0] if isinstance(level, bytes) else int(level)
