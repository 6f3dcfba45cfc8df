"""The tab with the graph of nodes and topics, and its pictures as SVG."""
import threading
import time
from typing import Dict, Optional, Tuple

import rospy
from fastapi import FastAPI, Response
from nicegui import ui

from img_recog.errors import UserError, one_line
from img_recog.graph import dot
from img_recog.graph.reader import System, SystemReader, visible
from img_recog.nodes.web.page_elements import Visit

_PERIOD_S = 1.0         # a graph that was read is shown to all pages for this time
_LIGHT = dot.Colors('transparent', '#111827', '#ffffff', '#eff6ff', '#b91c1c')
_DARK = dot.Colors('transparent', '#e5e7eb', '#1f2937', '#1e3a5f', '#f87171')


def add(visit: Visit) -> None:
    """Add the elements of the tab."""
    with ui.element('section').classes('card'):
        ui.checkbox(visit.texts('leaves'), value=True, on_change=lambda event: ui.run_javascript(
            'document.querySelector("[data-graph]").dataset.graph = {}; loadGraph()'.format(
                int(event.value)))).props('dense')
        with ui.element('div').classes('graph'):
            ui.element('img').props('data-graph=1 alt="{}"'.format(visit.texts('graph_label')))
            ui.element('p').props('data-bind=graph role=status')


def serve(app: FastAPI) -> None:
    """Add the pictures to the application."""
    pictures = GraphPictures()

    @app.get('/graph.svg')
    def graph(dark: bool = False, leaves: bool = False) -> Response:
        try:
            return Response(pictures.draw(dark, leaves), media_type='image/svg+xml',
                            headers={'Cache-Control': 'no-store'})
        except UserError as error:
            return Response(one_line(error), status_code=503)


class GraphPictures:
    """Reads the system without this node, and draws it once for all pages. For any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._reader: Optional[SystemReader] = None
        self._system: Optional[System] = None
        self._read_s = 0.0
        self._drawn: Dict[Tuple[bool, bool], bytes] = {}

    def draw(self, is_dark: bool, leaves: bool) -> bytes:
        """Return the graph of nodes and topics as SVG; raise UserError if that fails.

        is_dark: for a dark page; leaves: with topics that have one end only.
        """
        with self._lock:
            system = self._read()
            if (is_dark, leaves) not in self._drawn:
                self._drawn[is_dark, leaves] = dot.draw(
                    dot.to_dot(visible(system, leaves), _DARK if is_dark else _LIGHT), 'svg')
            return self._drawn[is_dark, leaves]

    def _read(self) -> System:
        if self._system is None or time.monotonic() - self._read_s > _PERIOD_S:
            self._reader = self._reader or SystemReader()
            self._system = self._reader.read().without(rospy.get_name())
            self._read_s, self._drawn = time.monotonic(), {}
        return self._system
