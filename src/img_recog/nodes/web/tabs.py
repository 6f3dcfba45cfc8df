"""The tabs of the page. A new one is its module, a row of TABS and its texts."""
from typing import Any, Callable, NamedTuple, Optional

from fastapi import FastAPI

from img_recog.nodes.web import (
    colors_tab, graph_tab, live_tab, log_tab, navigation_tab, nodes_tab)
from img_recog.nodes.web.measurements import Source
from img_recog.nodes.web.page_elements import Visit


class Tab(NamedTuple):
    """A tab.

    name: the key of its title in page_texts.txt, and the name of its script static/NAME.js.
    add: adds its elements to a page. update: shows what other pages and nodes have changed, every
    0.4 s; is called with what `add` has returned. topics: those that only it shows. serve: adds
    what its elements load. is_there: whether a page has it now; None for always.
    """

    name: str
    add: Callable[[Visit], Any]
    update: Optional[Callable[[Any], None]] = None
    topics: Optional[Source] = None
    serve: Optional[Callable[[FastAPI], None]] = None
    is_there: Optional[Callable[[Visit], bool]] = None


TABS = (
    Tab('live', live_tab.LiveTab, live_tab.LiveTab.update),
    Tab('navigation', navigation_tab.add, is_there=navigation_tab.is_there),
    Tab('colors', colors_tab.ColorsTab, colors_tab.ColorsTab.update),
    Tab('graph', graph_tab.add, serve=graph_tab.serve),
    Tab('nodes', nodes_tab.add, topics=nodes_tab.topics),
    Tab('log', log_tab.add, topics=log_tab.topics))
