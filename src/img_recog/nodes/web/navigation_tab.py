"""The tab with the map of SLAM or navigation: a click sets a goal, dragging the initial pose."""
from typing import Any

from nicegui import ui

from img_recog.nodes.web.page_elements import Visit, card, numbers, paragraph, wait_for

TEXTS = {
    'navigation': ('Navigation', 'ナビゲーション'),
    'navigation_help': (
        'Click: a goal. Drag: where the robot is and its heading, for a localization. x is up.',
        'クリック: 目標。ドラッグ: 自己位置推定に、ロボットの位置と向きを教えます。上が x。'),
    'navigation_label': ('The map with robot, laser scan and plan; x is up',
                         'ロボット、レーザスキャン、経路計画を示す地図（上が x）'),
    'no_place': ('The place of the robot in the map is not known: nobody publishes the transform '
                 'from the frame of the map to that of the odometry.',
                 '地図でのロボットの位置が分かりません。地図の座標系からオドメトリの座標系への変換が'
                 '配信されていません。')}


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
