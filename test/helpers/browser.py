"""A headless browser that shows the page of the node web."""
import contextlib
import copy
import re
import shutil
import urllib.error
import urllib.request

import pytest

from img_recog_helpers.processes import Ros
from img_recog_helpers.waiting import wait_for

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    _MISSING = ''
except ImportError as error:
    _MISSING = str(error)

_POSE = re.compile(r'x (-?[0-9.]+) m, y (-?[0-9.]+) m')
_TABS = ('live', 'navigation', 'colors', 'graph', 'nodes', 'log')
# its icon has a text, too
_BUTTON = ('const button = (text) => [...document.querySelectorAll("button .block")].find('
           '(each) => each.textContent === text);')


def need_chromium():
    """Skip the test where there is no browser."""
    if _MISSING:
        pytest.skip('selenium cannot be loaded: {}: no test of the page'.format(_MISSING))
    if not (shutil.which('chromium') and shutil.which('chromedriver')):
        pytest.skip('chromium and chromium-driver are not installed: no test of the page')


@contextlib.contextmanager
def demo_with_page(folder, *arguments):
    """Run a demo with the page in an empty world, unless another one is given; yield its Ros.

    ros.url: of the page; ros.process: of the demo. The view is drawn seldom: at its usual rate,
    drawing it and showing it take more CPU time than all else.
    """
    need_chromium()
    with Ros(folder) as ros:
        ros.start_master()
        ros.set_parameters('/gazebo/view_rate', 2.0)
        ros.process = ros.demo('world:=empty', 'web:=true', *arguments, cwd=str(folder),
                               env=dict(ros.env, PWD=str(folder)))
        ros.url = ros.process.wait_output(r'the page: (http://\S+)').group(1)
        yield ros


class Browser:
    """A window of Chromium."""

    def __init__(self, folder, width=1280, height=800):
        options = Options()
        for argument in ('--headless=new', '--no-sandbox', '--disable-gpu',
                         '--disable-dev-shm-usage', '--lang=en',
                         '--user-data-dir=' + str(folder),
                         '--window-size={},{}'.format(width, height)):
            options.add_argument(argument)
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
        self._driver = webdriver.Chrome(service=Service(shutil.which('chromedriver')),
                                        options=options)
        self._window = self._driver.current_window_handle
        self._current = [self._window]          # of the windows of this browser
        self._set_up(width, height, 'en', False)

    def another(self, width, height, language='en', dark=False):
        """Return another window of this browser, which takes much less CPU time than another one.
        """
        other = copy.copy(self)
        self._driver.switch_to.new_window('window')
        other._window = self._current[0] = self._driver.current_window_handle
        other._set_up(width, height, language, dark)
        return other

    def _set_up(self, width, height, language, dark):
        """Make it the window of another device and person, and the one with the focus."""
        self.resize(width, height)
        for command, values in (
                ('Emulation.setEmulatedMedia', {'features': [
                    {'name': 'prefers-color-scheme', 'value': 'dark' if dark else 'light'}]}),
                ('Emulation.setUserAgentOverride', {
                    'userAgent': self.js('return navigator.userAgent'),
                    'acceptLanguage': language}),
                ('Emulation.setFocusEmulationEnabled', {'enabled': True})):
            self.driver.execute_cdp_cmd(command, values)

    @property
    def driver(self):
        """Selenium's, which works for this window."""
        if self._current[0] != self._window:
            self._driver.switch_to.window(self._window)
            self._current[0] = self._window
        return self._driver

    def resize(self, width, height):
        """Change its size, as if it was that of another device."""
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
            'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 600})

    def open(self, url):
        """Open the page and wait until it shows measurements."""
        self.driver.get(url)
        wait_for(lambda: self.text('[data-bind=pose]'),
                 lambda: 'measurements in the page: ' + self.js(
                     'return document.body.innerText')[:2000])

    def js(self, script, *arguments):
        """Run a script in the page; return its result."""
        return self.driver.execute_script(script, *arguments)

    def has_button(self, text):
        """Return whether there is a button with this text, and in sight."""
        return self.js(_BUTTON + 'const found = button(arguments[0]);'
                       'return Boolean(found && found.offsetParent)', text)

    def click(self, text):
        """Click the button with this text."""
        self.js(_BUTTON + 'button(arguments[0]).click()', text)

    def text(self, selector):
        """Return the text of the first element; empty if there is none."""
        return self.js('const found = document.querySelector(arguments[0]);'
                       'return found ? found.textContent : ""', selector)

    def tab(self, name):
        """Choose a tab."""
        self.js('document.querySelectorAll(".q-tab")[arguments[0]].click()', _TABS.index(name))

    def titles(self):
        """Return the headings of the cards that are shown."""
        return self.js("""return [...document.querySelectorAll(".card h2")].filter(
                            (each) => each.offsetParent).map((each) => each.textContent)""")

    def pose(self):
        """Return x and y in m, as the page says them."""
        found = _POSE.search(self.text('[data-bind=pose]'))
        return float(found.group(1)), float(found.group(2))

    def pixels(self, topic):
        """Return the mean color (r, g, b) of the picture of a topic; None if there is none."""
        return self.js('''
            const canvas = [...document.querySelectorAll("canvas[data-picture]")].find(
              (each) => each.dataset.picture === arguments[0] && each.offsetParent);
            if (!canvas || !canvas.parentElement.classList.contains("there")) return null;
            const data = canvas.getContext("2d").getImageData(
              0, 0, canvas.width, canvas.height).data;
            const sum = [0, 0, 0];
            for (let i = 0; i < data.length; i += 4) {
              for (let c = 0; c < 3; c += 1) sum[c] += data[i + c];
            }
            return sum.map((each) => 4 * each / data.length);''', topic)

    def hold_key(self, key, is_down):
        """Press or release a key."""
        chain = ActionChains(self.driver)
        (chain.key_down if is_down else chain.key_up)(key).perform()

    def errors(self):
        """Return what the browser logged as errors since the last call."""
        return [entry['message'] for entry in self.driver.get_log('browser')
                if entry['level'] == 'SEVERE']

    def close(self):
        """Close the window; the last one ends the browser."""
        if len(self.driver.window_handles) > 1:
            self.driver.close()
        else:
            self.driver.quit()


def status_of(url, **headers):
    """Return the HTTP status and the text of a request without a browser."""
    request = urllib.request.Request(url, headers={
        name.replace('_', '-'): value for name, value in headers.items()})
    try:
        with urllib.request.urlopen(request, timeout=30) as answer:
            return answer.status, answer.read().decode(errors='replace')
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode(errors='replace')
