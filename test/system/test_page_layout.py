"""What fits on the screen of the page: with eight rules of config/follow.yaml, and with none."""
import contextlib
import os

import pytest

from img_recog_helpers.browser import Browser, demo_with_page
from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import wait_for

TABS = ('live', 'colors', 'graph', 'nodes', 'log')
RULES = ('search', 'left', 'right', 'ahead', 'near_left', 'near_right', 'near', 'red_near')
TITLES = '''return [...document.querySelectorAll(".card h2")].filter(
              (each) => each.offsetParent).map((each) => each.textContent)'''
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


@contextlib.contextmanager
def browser(folder, url, **options):
    """Open the page in a browser; yield it."""
    with contextlib.closing(Browser(folder, **options)) as page:
        page.open(url)
        yield page


@pytest.fixture(scope='module')
def follower(tmp_path_factory):
    """The address of the page of a demo with eight rules; few and small images are faster."""
    with demo_with_page(tmp_path_factory.mktemp('follower'), 'camera:=robot', 'teleop:=false',
                        'world:=color_posts', 'image_width:=160', 'image_height:=120',
                        'framerate:=10',
                        'colors:=' + os.path.join(ROOT, 'config', 'follow.yaml')) as ros:
        yield ros.url


@pytest.fixture(scope='module')
def desk(follower, tmp_path_factory):
    """The tab Live of this demo on a small desk."""
    with browser(tmp_path_factory.mktemp('desk'), follower, width=1280, height=800) as page:
        yield page


def test_no_tab_is_wider_than_a_phone(follower, tmp_path):
    with browser(tmp_path, follower, width=390, height=844) as page:
        for tab in TABS:
            page.tab(tab)
            wait_for(lambda: page.js(
                'return [...document.querySelectorAll(".q-tab-panel")].some('
                '(each) => each.offsetParent)'), 'the tab')
            if tab == 'colors':
                wait_for(lambda: page.js('return document.querySelectorAll(".q-slider").length')
                         > 8 * 5, 'the sliders')
            if tab == 'graph':
                wait_for(lambda: page.js('return (document.querySelector("[data-graph]") || {})'
                                         '.naturalWidth > 390'), 'the graph')
            assert page.js('return [innerWidth, document.documentElement.scrollWidth]') == [
                390, 390], tab
            assert page.js(TOO_WIDE) == [], tab


def test_eight_rules_leave_room_for_the_simulator_and_are_told_apart(desk):
    masks = ['{}: recognized pixels'.format(name) for name in RULES]
    wait_for(lambda: set(masks) <= set(desk.js(TITLES)), lambda: desk.js(TITLES))
    assert [title for title in desk.js(TITLES) if title in ('Camera', 'Simulator', *masks)] \
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


def test_without_recognition_nothing_waits_for_it(tmp_path):
    (tmp_path / 'demo').mkdir()
    with demo_with_page(tmp_path / 'demo', 'vision:=false') as ros, browser(
            tmp_path / 'browser', ros.url) as page:
        wait_for(lambda: 'Simulator' in page.js(TITLES), lambda: page.js(TITLES))
        titles = page.js(TITLES)
        assert not [title for title in titles if 'recognized' in title or 'Areas' in title]
        assert {'Map', 'Speed (m/s)', 'Drive', 'Simulation'} <= set(titles)
        shown = 'return document.querySelector(".board").innerText'
        assert 'the colors command' not in page.js(shown)
        wait_for(lambda: 'no image yet' not in page.js(shown), 'the pictures that there are')
