"""The page in a real browser, on a real demo."""
import asyncio
import contextlib
import json
import math
import os
import re
import shlex
import socket
import time

import cv2
import numpy as np
import pytest
import rosbag
import yaml
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from img_recog_helpers import wire
from img_recog_helpers.browser import Browser, demo_with_page, status_of
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import Echo
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for

CAMERA, BLUE, RED = '/usb_cam/image_raw', '/blue_image', '/red_image'
CARD_SHARE = 0.25       # of the image
AGAIN_S = 5.0           # after which a click without effect is repeated
VIEWERS = 20
DRIVE_PERIOD_S = 0.1    # in which a browser repeats what is held
DESK, PHONE = (1280, 800), (390, 844)
PAGE_DOWN = '\ue00f'    # selenium's name of the key; it moves a slider by ten steps
ALT, ENTER, LEFT = '\ue00a', '\ue007', '\ue012'
HELD = '''return [...document.querySelectorAll("[data-drive].held")].map(
              (each) => each.getAttribute("aria-label"))'''

# whether the four corners and the middle of a picture are on the screen, with nothing above them
IN_SIGHT = '''
    const canvas = [...document.querySelectorAll("canvas[data-picture]")].find(
      (each) => each.dataset.picture === arguments[0] && each.offsetParent);
    if (!canvas) return false;
    const box = canvas.getBoundingClientRect();
    return [[0.05, 0.05], [0.95, 0.05], [0.5, 0.5], [0.05, 0.95], [0.95, 0.95]].every(
      ([x, y]) => canvas.parentElement.contains(document.elementFromPoint(
        box.left + x * box.width, box.top + y * box.height)));'''


@pytest.fixture(scope='module')
def demo(tmp_path_factory):
    """A demo with the page; its camera shows a blue card, which is too small for a command.

    taken: the port at which the page was to be.
    """
    folder = tmp_path_factory.mktemp('a page')      # a command with it has to be quoted
    image = np.full((240, 320, 3), (190, 200, 206), np.uint8)
    image[60:180, 80:240] = (215, 70, 25)
    assert cv2.imwrite(str(folder / 'card.png'), image)
    (folder / 'colors.yaml').write_text('blue_area_limit: 200000\nred_area_limit: 200000\n'
                                        'max_image_pixels: 9000000\n')
    with socket.create_server(('127.0.0.1', 0)) as taken, demo_with_page(
            folder, 'camera:={}/card.png'.format(folder),
            'colors:={}/colors.yaml'.format(folder), 'x_pos:=0', 'y_pos:=0', 'framerate:=5',
            'web_port:={}'.format(taken.getsockname()[1])) as ros:
        ros.taken = taken.getsockname()[1]
        ros.origin, ros.token = ros.url.split('/?token=')
        ros.folder = folder
        ros.speeds = Echo(ros, '/odom/twist/twist/linear/x')
        ros.services = ServiceCalls(ros)
        yield ros
        ros.services.close()


@pytest.fixture(scope='module')
def browser(demo, tmp_path_factory):
    """A browser that shows the page; to load it takes two seconds of CPU time."""
    with contextlib.closing(Browser(tmp_path_factory.mktemp('desk'))) as browser:
        browser.open(demo.url)
        yield browser


@pytest.fixture
def page(browser):
    """The page in the window of a desk, for tests that leave it open."""
    browser.resize(*DESK)
    browser.tab('live')
    wait_for(lambda: browser.text('[data-bind=pose]'), 'measurements in the page')
    browser.errors()        # so that the test gets only its own
    return browser


@pytest.fixture
def phone(demo, browser):
    """The page on a phone: narrow, Japanese and dark."""
    with contextlib.closing(browser.another(*PHONE, language='ja', dark=True)) as phone:
        phone.open(demo.url)
        yield phone


def speeds(demo, count=1):
    """Return the next speeds of the robot in m/s."""
    return [speed for speed, in demo.speeds.wait_more(count)[-count:]]


def wait_drives(page):
    """Wait until the robot has driven in any direction: another test may have turned it."""
    start = page.pose()
    wait_for(lambda: math.dist(page.pose(), start) > 0.1, 'the robot to drive')


def blueness(page):
    """Return the mean blue, 0 to 255, of the picture of the blue pixels; -1 if there is none."""
    return (page.pixels(BLUE) or [-1])[-1]


def parameter(demo, name):
    """Return a parameter of the recognition."""
    return demo.parameter('/color_extract/' + name)


def set_parameters(demo, **integers):
    """Change parameters of the recognition, as dynparam does."""
    demo.services.call('/color_extract/set_parameters', {'config': {'ints': [
        {'name': name, 'value': value} for name, value in integers.items()]}})


def repeat_until(action, condition, what):
    """Wait for the effect of an action; it may be repeated, as its receiver may not be there yet.
    """
    acted_s = float('-inf')

    def has_effect():
        nonlocal acted_s
        if time.monotonic() > acted_s + AGAIN_S * stretch():
            action()
            acted_s = time.monotonic()
        return condition()
    wait_for(has_effect, what)


def test_pictures_and_measurements(page):
    camera = wait_for(lambda: page.pixels(CAMERA), 'a picture of the camera')
    # a quarter is the card, the rest the wall; BGR in the image, RGB here
    expected = [CARD_SHARE * card + (1 - CARD_SHARE) * wall
                for card, wall in zip((25, 70, 215), (206, 200, 190))]
    assert camera == pytest.approx(expected, abs=4)
    blue = wait_for(lambda: page.pixels(BLUE), 'a picture of the blue pixels')
    assert blue == pytest.approx([CARD_SHARE * each for each in (25, 70, 215)], abs=4)
    wait_for(lambda: page.text('[data-bind=connection]') == 'connected', 'the connection')
    wait_for(lambda: page.text('[data-bind=factor]'),
             'the real time factor')
    page.tab('nodes')
    wait_for(lambda: 'color_extract: recognition' in page.text('[data-nodes]'), 'the nodes')
    page.tab('log')
    wait_for(lambda: 'blue=19200, red=0' in page.text('[data-log]'), 'the log')
    assert page.errors() == []


def test_a_key_moves_the_robot_and_its_release_stops_it(demo, page):
    start_x, _ = page.pose()
    page.hold_key('w', True)
    wait_for(lambda: page.pose()[0] > start_x + 0.15, 'the robot to drive')
    # the idle teleop does not disturb; a browser may pause on a busy machine
    wait_for(lambda: speeds(demo, 10) == pytest.approx(10 * [0.22], abs=0.02), 'a steady speed')
    page.hold_key('w', False)
    wait_for(lambda: speeds(demo) == pytest.approx([0.0], abs=0.01), 'the robot to stand')
    stood = page.pose()
    page.hold_key('x', True)
    wait_for(lambda: page.pose()[0] < stood[0] - 0.1, 'the robot to drive backward')
    page.hold_key('x', False)


def test_a_key_that_is_held_does_not_matter_after_a_stop(page):
    for key, remaining in (('s', ['Stop']), ('S', ['Stop']), (ALT, [])):
        page.hold_key('w', True)
        assert page.js(HELD) == ['Forward']
        page.hold_key(key, True)
        assert page.js(HELD) == remaining
        page.hold_key('w', False)
        assert page.js(HELD) == remaining
        page.hold_key(key, False)
        assert page.js(HELD) == []


@pytest.mark.parametrize('key', [ENTER, ' '])
def test_a_button_drives_as_long_as_a_key_is_held_on_it(page, key):
    for direction, name in (('1,0', 'Forward'), ('0,0', 'Stop')):
        page.js('document.querySelector(`[data-drive="${arguments[0]}"]`).focus()', direction)
        page.hold_key(key, True)
        assert page.js(HELD) == [name]
        page.hold_key(key, False)
        assert page.js(HELD) == []


def test_arrow_keys_drive_after_a_click_on_a_tab(page):
    page.driver.find_elements('css selector', '.q-tab')[0].click()
    page.hold_key(LEFT, True)
    assert page.js(HELD) == ['Turn left']
    page.hold_key(LEFT, False)
    assert page.js(HELD) == []


def test_the_joystick_of_a_phone_drives_the_robot_at_any_speed(demo, page):
    stick = 'const stick = document.querySelector("[data-stick]");'
    assert not page.js(stick + 'return stick.offsetParent')
    page.resize(*PHONE)
    box = page.js(stick + 'const { right, bottom } = stick.getBoundingClientRect();'
                  'return [innerWidth - right, innerHeight - bottom]')
    assert 0 <= box[0] < 30 and 0 <= box[1] < 30
    send = stick + """stick.setPointerCapture = () => {};
        const box = stick.getBoundingClientRect();
        stick.dispatchEvent(new PointerEvent(arguments[0], {
          bubbles: true, pointerId: 5, isPrimary: true, clientX: box.left + box.width / 2,
          clientY: box.top + arguments[1] * box.height }))"""
    page.js(send, 'pointerdown', 0.4)
    page.js(send, 'pointermove', 0.25)          # half of the highest speed
    wait_for(lambda: speeds(demo, 10) == pytest.approx(10 * [0.11], abs=0.02), 'half the speed')
    page.js(send, 'pointerup', 0.25)
    wait_for(lambda: speeds(demo) == pytest.approx([0.0], abs=0.01), 'the robot to stand')


def test_a_held_key_ends_with_the_connection(demo, page):
    script = page.driver.execute_cdp_cmd('Page.addScriptToEvaluateOnNewDocument', {'source': '''
        window.sockets = [];
        window.WebSocket = class extends WebSocket {
          constructor(...words) { super(...words); window.sockets.push(this); }
        };'''})
    page.open(demo.url)
    page.driver.execute_cdp_cmd('Page.removeScriptToEvaluateOnNewDocument', script)
    page.hold_key('w', True)
    wait_drives(page)
    opened = 'return sockets.filter((each) => each.url.includes("/live")'
    count = len(page.js(opened + ')'))
    page.js(opened + ').forEach((each) => each.close())')
    wait_for(lambda: len(page.js(opened + ' && each.readyState === 1)')) == 1
             and len(page.js(opened + ')')) > count, 'another connection')
    assert page.js(HELD) == []
    wait_for(lambda: speeds(demo, 10) == pytest.approx(10 * [0.0], abs=0.01), 'the robot to stand')
    page.hold_key('w', False)


@pytest.mark.parametrize('size', [DESK, PHONE])
def test_pictures_and_save_are_in_sight_while_a_slider_of_the_color_is_touched(page, size):
    # before the tests that save files: the names of these cover the pictures for ten seconds
    page.resize(*size)
    page.tab('colors')
    slider = 'const sliders = [...document.querySelectorAll(".q-slider [tabindex]")];' \
             'const slider = sliders[(arguments[0] + sliders.length) % sliders.length];'
    wait_for(lambda: page.js(slider + 'return sliders.length', 0) > 4, 'the sliders')
    for number, seen, hidden in ((-1, RED, BLUE), (0, BLUE, RED)):
        repeat_until(lambda: page.js(slider + 'slider.blur(); slider.focus()', number),
                     lambda: page.js(IN_SIGHT, seen), 'the picture of ' + seen)
        assert page.js(IN_SIGHT, CAMERA) and not page.js(IN_SIGHT, hidden)
        assert page.js('return innerWidth') == size[0]
        for element in 'slider', 'document.querySelector(".at-hand")':
            assert page.js(slider + 'const box = {}.getBoundingClientRect();'
                           'return box.top >= 0 && box.bottom <= innerHeight'.format(element),
                           number), element


def test_a_slider_changes_the_areas_and_a_file_gets_them(demo, page):
    page.tab('colors')
    slider = ('[...document.querySelectorAll(".q-slider")].find((each) => '
              'each.getAttribute("aria-label") === "blue: Highest hue (0 to 180)")')
    wait_for(lambda: page.js('return Boolean({})'.format(slider)), 'the sliders')
    wait_for(lambda: blueness(page) > 40, 'blue pixels')
    element = page.js('return {}.querySelector("[tabindex]")'.format(slider))
    element.send_keys(5 * PAGE_DOWN)        # faster than the page's node can answer
    wait_for(lambda: page.js('return {}.getAttribute("aria-valuenow")'.format(slider)) == '100',
             'the slider to move')
    wait_for(lambda: 0 <= blueness(page) < 1, 'no more blue pixels')
    wait_for(lambda: parameter(demo, 'blue_hue_max') == 100, 'the parameter')
    page.click('Save as a file')
    saved = wait_for(lambda: list(demo.folder.glob('colors_*.yaml')), 'a file')
    values = yaml.safe_load(saved[0].read_text())
    assert values['blue_hue_max'] == 100 and values['colors'] == ['blue', 'red']
    assert values['blue_area_limit'] == 200000 and values['max_image_pixels'] == 9000000
    command = wait_for(lambda: page.text('.q-notifications').rpartition('To use it: ')[2],
                       'what to do with the file')
    assert shlex.split(command) == ['./run', 'demo', 'colors:={}'.format(saved[0])]
    page.click('Undo')
    wait_for(lambda: parameter(demo, 'blue_hue_max') == 150, 'the value of before')
    wait_for(lambda: not page.has_button('Undo'), 'nothing to be left to take back')
    for value, light in ((100, 0), (150, 55)):
        set_parameters(demo, blue_hue_max=value)
        wait_for(lambda: blueness(page) == pytest.approx(light, abs=15), 'other blue pixels')
        wait_for(lambda: page.js('return {}.getAttribute("aria-valuenow")'.format(slider)) == str(
            value), 'the value that another program has set')


def touch(page, *places):
    """Press at the first place in the camera picture, move to the others, and let go at the last.
    """
    page.js('''
        const canvas = [...document.querySelectorAll("canvas.pick")].find(
          (each) => each.offsetParent);
        canvas.setPointerCapture = () => {};
        const box = canvas.getBoundingClientRect();
        const send = (kind, [x, y]) => canvas.dispatchEvent(new PointerEvent(kind, {
          bubbles: true, pointerId: 1, isPrimary: true, clientX: box.left + x * box.width,
          clientY: box.top + y * box.height }));
        const places = arguments[0];
        send("pointerdown", places[0]);
        places.slice(1).forEach((place) => send("pointermove", place));
        send("pointerup", places[places.length - 1]);''', places)


def test_samples_give_bounds_that_are_used_and_files_for_fit_colors(demo, page):
    page.tab('colors')
    wait_for(lambda: page.js('return document.querySelectorAll(".q-slider").length') > 4,
             'the sliders')
    wait_for(lambda: page.pixels(CAMERA), 'a picture')
    said = (lambda: 'the page says: ' + page.text('.q-notifications') + page.text('.offers'))
    lines = 'return document.querySelectorAll(".picture.held polygon").length'
    touch(page, (0.5, 0.5))
    wait_for(lambda: page.js(lines) == 1, said)
    page.click('none of them')
    touch(page, (0.02, 0.05), (0.08, 0.3), (0.12, 0.35))
    wait_for(lambda: page.js(lines) == 2, said)
    touch(page, (0.15, 0.5), (0.35, 0.6))
    wait_for(lambda: 'contradict each other: 50.0% of sample 3 is blue' in page.text(
        '.q-notifications'), said)
    # the offers are drawn anew while their picture comes, and are empty meanwhile
    numbers = wait_for(lambda: page.has_button('Use for blue') and [
        float(each) for each in re.findall(r'[0-9.]+[0-9]', page.text('.offers'))], said)
    assert len(numbers) == 8 and numbers[6] > 99.5 and numbers[7] < 0.1
    names = ['blue_{}_{}'.format(part, end) for part in ('hue', 'saturation', 'value')
             for end in ('min', 'max')]
    offered = dict(zip(names, map(int, numbers)))
    page.click('Use for blue')
    wait_for(lambda: {name: parameter(demo, name) for name in names} == offered, said)
    wait_for(lambda: page.has_button('Undo'), said)
    page.click('Undo')
    wait_for(lambda: parameter(demo, 'blue_hue_min') == 50, said)
    wait_for(lambda: not page.has_button('Undo'), said)
    page.click('Save the samples')
    folder = demo.folder / 'samples_1'
    wait_for(folder.exists, said)
    wait_for(lambda: "rosrun img_recog fit_colors.py '{0}' --samples '{0}'/samples.yaml".format(
        folder) in page.text('.q-notifications'), said)
    page.click('Live picture')
    wait_for(lambda: page.js(lines) == 0 and page.has_button('Hold the picture'), said)
    assert (folder / 'samples.yaml').exists()


def test_a_click_into_the_map_moves_the_robot_and_a_button_moves_it_back(page):
    # what the map shows depends on where the robot was
    wait_for(lambda: page.js('return document.querySelector("canvas.map").extent'), 'the map')
    repeat_until(lambda: page.js('''
        const canvas = document.querySelector("canvas.map");
        const box = canvas.getBoundingClientRect();
        const [x, y, size] = canvas.extent;
        const at = { bubbles: true, pointerId: 1, isPrimary: true,
          clientX: box.right - (0.4 - y) / size * box.width,
          clientY: box.bottom - (0.7 - x) / size * box.height };      // x is upward
        canvas.setPointerCapture = () => {};
        canvas.dispatchEvent(new PointerEvent("pointerdown", at));
        canvas.dispatchEvent(new PointerEvent("pointerup", at));'''),
                 lambda: page.pose() == pytest.approx((0.7, 0.4), abs=0.05),
                 lambda: 'the robot at another place: {}'.format(page.pose()))
    repeat_until(lambda: page.click('Back to the start'),
                 lambda: page.pose() == pytest.approx((0.0, 0.0), abs=0.05), 'the start')


def test_the_speed_is_seen_beside_commands_far_above_it(demo, page):
    chart = ('const name = document.querySelector("[data-chart=speeds]").id;'
             'const option = getElement(Number(name.slice(1))).chart.getOption();'
             'return [option.yAxis[0].max, option.series[0].name]')
    set_parameters(demo, blue_area_limit=100)
    try:
        name = ['asked: 0 to 10, cut off at the edge']
        wait_for(lambda: page.js(chart)[1:] == name, lambda: page.js(chart))
        assert 0.2 < page.js(chart)[0] <= 1.0
    finally:
        set_parameters(demo, blue_area_limit=200000)
        page.click('Back to the start')


def test_pause_and_resume(demo, page):
    repeat_until(lambda: page.click('Pause'),
                 lambda: page.text('[data-bind=factor]') == 'paused', 'the pause')
    repeat_until(lambda: page.click('Resume'),
                 lambda: re.match(r'0\.0*[1-9]|[1-9]', page.text('[data-bind=factor]')),
                 'time to pass')


def test_the_graph_has_the_nodes_of_the_article(demo, page):
    page.tab('graph')
    source = wait_for(lambda: page.js(
        'const image = document.querySelector("[data-graph]");'
        'return image && image.naturalWidth > 100 && image.src'), 'a drawn graph')
    fetch = ('const request = new XMLHttpRequest(); request.open("GET", arguments[0], false);'
             'request.send(); return request.responseText')
    assert 'dark=0' in source
    names = ('/usb_cam', '/color_extract', '/gazebo', '/turtlebot3_teleop_keyboard',
             '/usb_cam/image_raw', '/blue_image', '/red_image', '/cmd_vel')
    # a node that is slow to answer is drawn as one that does not answer
    wait_for(lambda: all('>{}</text>'.format(name) in page.js(fetch, source) for name in names),
             lambda: 'all names in ' + page.js(fetch, source))
    assert '>/web</text>' not in page.js(fetch, source)
    wait_for(lambda: ' Hz</text>' in page.js(fetch, source), 'rates')


def test_a_recording(demo, page):
    gazebo = wire.node_uri(demo.master_uri, '/gazebo')
    repeat_until(lambda: page.click('Record'), lambda: page.has_button('Stop recording'),
                 'the start')
    wait_for(lambda: any(topic == '/odom' and node.startswith('/record')
                         for _, node, _, _, topic, *_ in wire.call(gazebo, 'getBusInfo')),
             'odometry for the recording')
    speeds(demo, 20)
    page.click('Stop recording')
    bag = demo.folder / 'recording_1.bag'
    wait_for(bag.exists, 'the end of the recording')
    with rosbag.Bag(str(bag)) as recorded:
        assert recorded.get_message_count('/odom') > 0
    url = wait_for(lambda: page.js('''
        const link = [...document.querySelectorAll("a")].find(
          (each) => each.textContent === "Picture of the drive" && each.offsetParent);
        return link && link.href'''), 'a picture of the drive')
    cookie = 'img_recog_{}={}'.format(demo.origin.rpartition(':')[2], demo.token)
    assert status_of(url)[0] == 403 and status_of(url, Cookie=cookie)[0] == 200
    assert cv2.imread(str(demo.folder / 'recording_1.png')).shape == (900, 1400, 3)


@pytest.mark.parametrize('way', ['no token', 'wrong token', 'wrong cookie', 'foreign origin'])
def test_nothing_for_who_has_no_token_or_comes_from_elsewhere(demo, way):
    cookie = 'img_recog_{}={}'.format(demo.origin.rpartition(':')[2], demo.token)
    path, headers = {
        'no token': ('/', {}), 'wrong token': ('/?token=wrong', {}),
        'wrong cookie': ('/', {'Cookie': cookie + 'x'}),
        'foreign origin': ('/graph.svg', {'Cookie': cookie, 'Origin': 'http://evil.example'})}[way]
    code, text = status_of(demo.origin + path, **headers)
    assert code == 403 and 'address with the token' in text
    if way == 'no token':       # a user who has lost the address opens the page without the token
        lines = demo.process.output.count('the page: ' + demo.url)
        wait_for(lambda: status_of(demo.origin)[0] == 403 and demo.process.output.count(
            'the page: ' + demo.url) > lines, lambda: demo.process.output)
    assert status_of(demo.origin + '/graph.svg', Cookie=cookie)[0] == 200


def live(demo, **headers):
    """Return a connection to the WebSocket of the page."""
    cookie = 'img_recog_{}={}'.format(demo.origin.rpartition(':')[2], demo.token)
    return connect(demo.origin.replace('http', 'ws') + '/live', **dict({
        'origin': demo.origin, 'additional_headers': {'Cookie': cookie},
        'open_timeout': DEADLINE_S, 'ping_timeout': None}, **headers))


@pytest.mark.parametrize('headers', [
    {'origin': 'http://evil.example'}, {'additional_headers': {}}, {'origin': None}])
def test_a_web_socket_from_elsewhere_is_refused(demo, headers):
    async def refuse():
        with pytest.raises(InvalidStatus, match='403'):
            async with live(demo, **headers):
                pass
    asyncio.run(refuse())


def test_what_is_malformed_or_too_much_is_dropped_and_the_page_lives(demo, page):
    async def send(connection, *messages):
        for message in messages:
            await connection.send(message)

    async def hurry():
        async with live(demo) as connection:
            await send(connection, *['{"ready": 1}'] * 5000)

    async def attack(*messages):
        async with live(demo) as connection:
            with pytest.raises(ConnectionClosed):
                await send(connection, *messages)
                await asyncio.wait_for(connection.recv(), DEADLINE_S)
    drawn = '''return Math.max(...[...document.querySelectorAll("canvas[data-picture]")].map(
                   (each) => each.drawn || 0))'''
    asyncio.run(hurry())
    asyncio.run(attack('x' * 1_000_000))
    asyncio.run(attack(*['nonsense'] * 100))
    before = page.js(drawn)
    wait_for(lambda: page.js(drawn) > before, 'a new picture')


def test_two_browsers_of_which_one_drives_and_both_stop(demo, page, phone):
    first, second = page, phone
    first.hold_key('w', True)
    wait_drives(second)

    def is_refused():
        """Try to drive with the second; it takes over if the first browser has just paused."""
        second.hold_key('x', True)
        busy = wait_for(lambda: second.text('[data-bind=busy]') or first.text('[data-bind=busy]'),
                        'a refusal')
        if '別のページ' in busy:
            return True
        for each, key in ((second, 'x'), (first, 'w')):
            each.hold_key(key, False)
        wait_for(lambda: not first.text('[data-bind=busy]'), 'the end of the message')
        first.hold_key('w', True)
        return False
    wait_for(is_refused, 'the second to be refused')
    wait_drives(first)
    second.hold_key('x', False)
    second.hold_key('s', True)
    wait_for(lambda: 'Another page' in first.text('[data-bind=busy]'), 'the stop')
    second.hold_key('s', False)
    wait_for(lambda: speeds(demo, 10) == pytest.approx(10 * [0.0], abs=0.01),
             'the robot to stand, although the first one still holds its key')
    first.hold_key('w', False)
    assert second.js('return document.body.classList.contains("body--dark")')
    assert second.js('return document.documentElement.scrollWidth <= innerWidth')
    second.tab('graph')
    wait_for(lambda: 'dark=1' in second.js(
        'return document.querySelector("[data-graph]")?.src || ""'), 'a dark graph')


def test_the_robot_stops_when_a_browser_that_drives_it_goes_away(demo, page):
    async def drive():
        place = page.pose()
        connection = await live(demo)
        while math.dist(page.pose(), place) < 0.1:
            await connection.send('{"drive": [1, 0]}')
            await asyncio.sleep(DRIVE_PERIOD_S)
        connection.transport.abort()        # without a farewell, as when it is killed
    asyncio.run(drive())
    wait_for(lambda: speeds(demo) == pytest.approx([0.0], abs=0.01), 'the robot to stand')


def test_twenty_viewers(demo):
    async def view(number, received):
        async with live(demo) as socket:
            await socket.send(json.dumps({'look': [CAMERA, BLUE]}))
            while received[number] < 10:
                await socket.send('{"ready": 1}')
                data = await asyncio.wait_for(socket.recv(), DEADLINE_S)
                received[number] += b'"' + CAMERA.encode() + b'"' in data

    async def all_view():
        received = [0] * VIEWERS
        await asyncio.gather(*(view(number, received) for number in range(VIEWERS)))
        assert min(received) >= 10
    asyncio.run(all_view())


def test_a_page_whose_port_is_taken_gets_another_one(demo):
    port = int(demo.origin.rpartition(':')[2])
    assert port > demo.taken
    demo.process.wait_output('port {} is taken: the page is at port {}'.format(demo.taken, port))


def test_it_ends_quietly(demo):
    """The last test of this file."""
    assert demo.process.interrupt() == 0
    assert 'Traceback' not in demo.process.output
    assert demo.token not in ''.join(
        path.read_text(errors='replace') for path in (demo.folder / 'ros').rglob('*.log'))
    assert not os.path.exists(str(demo.folder / 'core'))
