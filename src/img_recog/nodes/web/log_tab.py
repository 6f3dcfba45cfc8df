"""The tab with the log of all nodes."""
import json
import re
import time
from typing import Dict, List, Tuple

from nicegui import ui
from rosgraph_msgs.msg import Log

from img_recog.errors import shortened
from img_recog.nodes.web.measurements import Topic
from img_recog.nodes.web.page_elements import Visit
from img_recog.nodes.web.updates import Updates

_REPEAT_S = 1.0         # lines of a level that differ only in numbers are sent once in this time
_MAX_KEPT = 100         # of each level, for a page that is opened now
_MAX_LINES = 1000       # whose times are known
_LEVELS = {Log.DEBUG: 'debug', Log.INFO: 'info', Log.WARN: 'warn', Log.ERROR: 'error',
           Log.FATAL: 'fatal'}
_CHOICES = ['debug', 'info', 'warn', 'error']
_NUMBERS = re.compile('[0-9]+')


def add(visit: Visit) -> None:
    """Add the elements of the tab."""
    with ui.element('section').classes('card'):
        ui.select(_CHOICES, value='info', label=visit.texts('level'),
                  on_change=lambda event: ui.run_javascript(
                      'filterLog({})'.format(json.dumps(event.value)))).props(
                          'dense options-dense').style('width: 160px')
        ui.element('div').classes('log').props(
            'data-log=info role=log tabindex=0 aria-label="{}"'.format(visit.texts('log')))


def topics(updates: Updates) -> List[Topic]:
    """Return the topic whose lines are put into `updates`."""
    sent_s: Dict[Tuple[str, str, str], float] = {}

    def logged(msg: Log) -> None:
        level, now_s = _LEVELS.get(msg.level, 'info'), time.monotonic()
        key = msg.name, level, _NUMBERS.sub('0', msg.msg[:200])
        if now_s - sent_s.get(key, -_REPEAT_S) < _REPEAT_S:
            return
        if len(sent_s) > _MAX_LINES:
            sent_s.clear()
        sent_s[key] = now_s
        updates.add('log', [round(msg.header.stamp.to_sec(), 3), level, shortened(msg.name),
                            shortened(msg.msg)], _MAX_KEPT, level)
    return [('/rosout_agg', Log, logged)]
