"""What fits on the screen of the page, with the eight rules of config/follow.yaml."""
import contextlib
import os
import re

import pytest

from img_recog_helpers.browser import Browser, demo_with_page
from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import wait_for

TABS = ('live', 'colors', 'graph', 'nodes', 'log')
RULES = ('search', 'left', 'right', 'ahead', 'near_left', 'near_right', 'near', 'red_near')
# elements that are cut off at the right edge
TOO_WIDE = '''const width = document.documentElement.clientWidth;
              return [...document.querySelectorAll("body *")].filter((each) => each.offsetParent
              && !each.matches("[data-graph]")
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


def test_the_texts_of_the_graph_are_readable(phone):
    phone.tab('graph')
    for width in 390, 1280:
        phone.resize(width, 844)
        # graphviz writes them with 14 pt
        wait_for(lambda: phone.js("""const image = document.querySelector("[data-graph]");
            return image && image.naturalWidth > 390
              && image.clientWidth / image.naturalWidth * 14 * 96 / 72 > 11.9"""),
                 'the size of the texts')


def test_the_lines_of_the_log_end_before_its_scroll_bar(phone):
    phone.tab('log')
    wait_for(lambda: phone.js("""const box = document.querySelector("[data-log]");
        if (!box || box.scrollHeight <= box.clientHeight) return false;
        const right = box.getBoundingClientRect().left + box.clientWidth;
        const range = document.createRange();
        range.selectNodeContents(box);
        return [...range.getClientRects()].every((each) => each.right <= right - 12)"""),
             'lines of the log')


def test_the_button_that_saves_the_colors_covers_no_slider(phone):
    phone.tab('colors')
    wait_for(lambda: phone.js('return document.querySelectorAll(".q-slider").length') > 8 * 5,
             'the sliders')
    assert phone.js("""scrollTo(0, 0);
        const box = document.querySelector(".at-hand").getBoundingClientRect();
        return [...document.querySelectorAll(".slider-row")].filter((each) => {
          const { top, bottom } = each.getBoundingClientRect();
          return top < box.bottom && bottom > box.top; }).length""") == 0
    hidden = """const sliders = [...document.querySelectorAll(".q-slider [tabindex]")];
        const slider = sliders[arguments[0]];
        slider.blur(); slider.focus();
        const { left, top, width, height } = slider.getBoundingClientRect();
        const found = document.elementFromPoint(left + width / 2, top + height / 2);
        return !(found && slider.parentElement.contains(found))"""
    for number in (0, 20, 40, 30, 10, 1):       # downward and upward
        wait_for(lambda: not phone.js(hidden, number), 'slider {} in sight'.format(number))


def test_the_stop_button_is_red(desk):
    script = """const button = document.querySelector("[data-drive='0,0']");
        return button && getComputedStyle(button).backgroundColor"""
    color = wait_for(lambda: desk.js(script), 'the stop button')
    red, green, blue = map(int, re.findall('[0-9]+', color)[:3])
    assert red > 150 and max(green, blue) < 60


@pytest.mark.parametrize('size', [(390, 844), (1280, 800)])
def test_a_picture_grows_on_a_click(browser, size):
    browser.resize(*size)
    browser.tab('live')
    picture = 'const picture = document.querySelector(".board .picture");'
    wait_for(lambda: browser.js(picture + 'return picture && picture.matches(".there")'),
             'an image')
    small = browser.js(picture + 'return picture.clientWidth')
    for end in ('picture.click()', 'document.dispatchEvent(new KeyboardEvent('
                                   '"keydown", { key: "Escape", bubbles: true }))'):
        browser.js(picture + 'picture.click()')
        left, top, width, height, is_on_top = browser.js(picture + """
            const box = picture.getBoundingClientRect();
            const above = document.elementFromPoint(innerWidth / 2, innerHeight / 2);
            return [box.left, box.top, box.width, box.height, picture.contains(above)]""")
        assert is_on_top and min(left, top) >= 0
        assert width == pytest.approx(size[0], abs=1) or height == pytest.approx(size[1], abs=1)
        browser.js(picture + end)
        assert browser.js(picture + 'return picture.clientWidth') == small


def test_the_names_of_near_robots_do_not_overlap(desk):
    names = [['tb3_{}'.format(number), [100 + number, 100], 40, 12] for number in range(8)]
    robots = [[100 + number, 100, 10] for number in range(8)] + [[140, 100, 12]]
    placed = desk.js('return page.mapping.placeLabels(arguments[0], 300, arguments[1])', names,
                     robots)
    assert [name for name, *_ in placed] == [name for name, *_ in names]
    for number, (_, x, y, width) in enumerate(placed):
        assert 0 <= x <= 300 - width
        for _, other_x, other_y, other_width in placed[:number]:
            assert abs(y - other_y) >= 12 or x >= other_x + other_width or other_x >= x + width
        for robot_x, robot_y, size in robots:       # the text is above its base line
            assert (y <= robot_y - size or y - 13 >= robot_y + size or x >= robot_x + size
                    or x + width <= robot_x - size)


def test_the_map_draws_no_edge_inside_of_a_wall(desk):
    """Two triangles make the top of a wall."""
    colors = desk.js("""const canvas = document.createElement("canvas");
        const context = canvas.getContext("2d");
        page.mapping.drawOutlines({ context, at: (each) => each },
          [[[10, 10], [90, 10], [90, 90]], [[10, 10], [90, 90], [10, 90]]], "#000", "#ccc");
        return [[50, 50], [70, 30], [30, 70], [30, 9]].map(
          ([x, y]) => context.getImageData(x, y, 1, 1).data[0])""")
    assert min(colors[:3]) > 190 and colors[3] < 150


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
