"""What fits on the screen of the page, with the eight rules of config/follow.yaml."""
import contextlib
import os

import pytest

from img_recog_helpers.browser import Browser, demo_with_page
from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import wait_for

TABS = ('live', 'colors', 'graph', 'nodes', 'log')
RULES = ('search', 'left', 'right', 'ahead', 'near_left', 'near_right', 'near', 'red_near')
# elements that are cut off at the right edge
TOO_WIDE = '''const width = document.documentElement.clientWidth;
              return [...document.querySelectorAll("body *")].filter((each) => each.offsetParent
              && each.getBoundingClientRect().right > width + 1).map(
              (each) => each.tagName + " " + each.className)'''
CHART = '''const element = document.querySelector(`[data-chart=${arguments[0]}]`);
           const chart = getElement(Number(element.id.slice(1))).chart;'''
# the texts at the axis of values of a chart
LABELS = CHART + '''return chart.getModel().getComponent("yAxis").axis.getViewLabels().map(
                    (each) => each.formattedLabel)'''


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    """The page of a demo with eight rules; few and small images are faster."""
    with demo_with_page(tmp_path_factory.mktemp('follower'), 'camera:=robot', 'teleop:=false',
                        'world:=color_posts', 'image_width:=160', 'image_height:=120',
                        'framerate:=10',
                        'colors:=' + os.path.join(ROOT, 'config', 'follow.yaml')) as ros:
        with contextlib.closing(Browser(tmp_path_factory.mktemp('browser'))) as browser:
            browser.open(ros.url)
            yield browser


@pytest.fixture
def phone(browser):
    """The page on a phone."""
    browser.resize(390, 844)
    return browser


@pytest.fixture
def desk(browser):
    """The tab Live on a small desk."""
    browser.resize(1280, 800)
    browser.tab('live')
    return browser


def test_no_tab_is_wider_than_a_phone(phone):
    for tab in TABS:
        phone.tab(tab)
        wait_for(lambda: phone.js(
            'return [...document.querySelectorAll(".q-tab-panel")].some('
            '(each) => each.offsetParent)'), 'the tab')
        if tab == 'colors':
            wait_for(lambda: phone.js('return document.querySelectorAll(".q-slider").length')
                     > 8 * 5, 'the sliders')
        if tab == 'graph':
            wait_for(lambda: phone.js('return (document.querySelector("[data-graph]") || {})'
                                      '.naturalWidth > 390'), 'the graph')
        wait_for(lambda: phone.js('return [innerWidth, document.documentElement.scrollWidth]')
                 == [390, 390] and not phone.js(TOO_WIDE), lambda: (tab, phone.js(TOO_WIDE)))


def test_eight_rules_leave_room_for_the_simulator_and_are_told_apart(desk):
    masks = ['{}: recognized pixels'.format(name) for name in RULES]
    wait_for(lambda: set(masks) <= set(desk.titles()), lambda: desk.titles())
    assert [title for title in desk.titles() if title in ('Camera', 'Simulator', *masks)] \
        == ['Camera', 'Simulator', *masks]
    bottom = desk.js('''return document.querySelector(
        "[data-picture='/gazebo/view/image_raw']").getBoundingClientRect().bottom''')
    assert 100 < bottom < 800
    # no area is flattened by the rule that takes all 19200 pixels
    labels = wait_for(lambda: len(desk.js(LABELS, 'areas')) > 3 and desk.js(LABELS, 'areas'),
                      'areas')
    assert labels[:4] == ['0', '10', '100', '1K']
    places = desk.js(CHART + '''return [0, 10, 19200].map((px) => chart.convertToPixel(
        { yAxisIndex: 0 }, Math.max(1, px)))''', 'areas')
    assert places[0] - places[1] > 0.15 * (places[0] - places[2])


def test_the_axis_of_the_speeds_has_round_numbers(desk):
    """0.3, whose third is no number of a computer: as ECharts has it, 0.30000000000000004."""
    formatted = CHART + '''const { formatter } = chart.getOption().yAxis[0].axisLabel;
        return formatter && [3 * 0.1, -0.15, 0, 12.5].map(formatter)'''
    wait_for(lambda: desk.js(formatted, 'speeds') == ['0.3', '-0.15', '0', '12.5'],
             lambda: desk.js(formatted, 'speeds'))


def test_the_labels_of_the_map_are_beside_the_walls(desk):
    def free():
        """Return the pixels at the left of the walls and below them; these are at 4.1 m."""
        return desk.js('''const canvas = document.querySelector("canvas.map");
            const [x, y, size] = canvas.extent || [0, 0, 1];
            const scale = canvas.clientWidth / size;
            return [(y + size - 4.1) * scale, (-4.1 - x) * scale]''')
    wait_for(lambda: 44 < free()[0] < 80 and 16 < free()[1] < 50, free)
