"""The tab with the map of SLAM or navigation: a click sets a goal, dragging the initial pose."""
from typing import Any

from nicegui import ui

from img_recog.nodes.web.page_elements import Visit, card, numbers, paragraph, wait_for


def add(visit: Visit) -> None:
    """Add the elements of the tab."""
    async def publish(event: Any) -> None:
        given = numbers(event, 'x', 'y', 'yaw', 'dragged')
        if given:
            await wait_for(visit.robot.navigation.publish, *given[:3], bool(given[3]))

    with card(visit.texts('navigation')):
        ui.element('canvas').classes('map navigation').props(
            'data-event=navigation role=img aria-label="{}"'.format(
                visit.texts('navigation_label')))
        ui.element('p').props('data-bind=place role=status')
        paragraph(visit.texts('navigation_help'))
    ui.on('navigation', publish, throttle=0.2)


def is_there(visit: Visit) -> bool:
    """Return whether there is a map."""
    return visit.robot.navigation.has_map
