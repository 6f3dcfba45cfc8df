"""What the page costs: CPU time of its node, and the latency of the recognition beside it."""
import json
import os
import re
import subprocess
import sys
from statistics import median
from typing import Callable, Dict

import recognition
from ros_processes import HERE, Master, cpu_s, free_port, run_script, wait_for

VIEWERS = (None, 0, 1, 20)      # None: without the node
ROUNDS = 3
SIZE, TURNS, SECONDS = (640, 480), 1, 8.0
TITLES = {None: 'without the page', 0: 'nobody looks', 1: 'one viewer', 20: '20 viewers'}


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return ROUNDS * len(VIEWERS)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over all rounds; each measures every number of viewers.

    done: called after each measurement.
    """
    found: Dict[str, list] = {name: [] for name in TITLES.values()}
    for _ in range(ROUNDS):
        for viewers in VIEWERS:
            found[TITLES[viewers]].append(_sample(viewers))
            done()
    first = found[TITLES[0]]
    return {'rows': [
        {'case': name, 'viewers_hz': median(each['viewers_hz'] for each in samples),
         'page_share': median(each['page_share'] for each in samples),
         'latency_ms': median(each['latency_ms'] for each in samples),
         'ratio': median(each['latency_ms'] / base['latency_ms']
                         for each, base in zip(samples, first))}
        for name, samples in found.items()]}


def _sample(viewers) -> dict:
    """Return CPU share of the page, rate of the viewers and latency of the recognition."""
    with Master() as master:
        topics, pids = recognition.script('scripts', 'color_img_recog.py')(master, 'node', False)
        web_pid, clients = 0, None
        if viewers is not None:
            web_pid, url = _start_page(master)
            clients = subprocess.Popen(
                [sys.executable, os.path.join(HERE, 'page_viewers.py'), url, str(viewers),
                 *('/node/' + name for name in ('usb_cam/image_raw', *recognition.IMAGES,
                                                'color_overlay'))],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, universal_newlines=True)
            wait_for(lambda: clients.stdout.readline() == 'connected\n', 'the viewers')
        before_s = cpu_s(web_pid) if web_pid else 0.0
        if viewers:         # the sample waits for the connections of these processes
            pids = pids + [web_pid]
        end = {'name': 'node', 'images': '/node/usb_cam/image_raw', 'pids': pids,
               'results': ['/node/' + topic for topic in topics], 'has_image_results': False}
        samples = run_script('recognition_sample.py', 'film', *SIZE, TURNS, SECONDS, 0,
                             json.dumps([end]), env=master.env)['node']
        used_s = cpu_s(web_pid) - before_s if web_pid else 0.0
        rate_hz = 0.0
        if clients is not None:
            clients.stdin.close()       # they print their rate and end
            rate_hz = float(clients.stdout.readline())
            clients.wait()
    # the sample also starts and warms up, while nothing or little is shown
    return {'page_share': used_s / SECONDS, 'viewers_hz': rate_hz,
            'latency_ms': median(each['latency_ms'] for each in samples)}


def _start_page(master: Master) -> tuple:
    """Start the node web; return its process id and the address of the page."""
    process = master.start(sys.executable, os.path.join(recognition.PACKAGE, 'scripts', 'web.py'),
                           '__ns:=/node', '_web_port:={}'.format(free_port()), output=True)
    for line in process.stdout:
        address = re.match(rb'the page: (\S+)', line)
        if address:
            return process.pid, address.group(1).decode()
    raise RuntimeError('the page did not start')


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:30} {:>20} {:>22} {:>24}'.format(
        'the page, film 640x480 at 30 Hz', 'CPU of a core', 'pictures to a viewer',
        'latency of recognition')]
    lines += ['{case:30} {page_share:18.1%} {viewers_hz:19.1f} Hz {latency_ms:13.2f} ms '
              '({ratio:.2f})'.format(**row) for row in results['rows']]
    return '\n'.join(lines)
