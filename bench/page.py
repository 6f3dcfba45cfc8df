"""What the page costs: CPU time of its node, and the latency of the recognition beside it."""
import os
import re
import subprocess
import sys
from statistics import median
from typing import Optional

import recognition
from pairs import Benchmark, Column
from ros_processes import HERE, Master, cpu_s, run_script, wait_for

SIZE, TURNS, SECONDS = (640, 480), 1, 8.0
VIEWERS = {'nobody looks': 0, 'without the page': None, 'one viewer': 1, '20 viewers': 20}


def _sample(viewers: Optional[int]) -> dict:
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
                             [end], env=master.env)['node']
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
    # it takes the next free port
    process = master.start_script('web.py', '__ns:=/node', output=True)
    for line in process.stdout:
        address = re.match(rb'the page: (\S+)', line)
        if address:
            return process.pid, address.group(1).decode()
    raise RuntimeError('the page did not start')


def benchmark() -> Benchmark:
    """Return what viewers of the page cost."""
    return Benchmark('the page, film 640x480 at 30 Hz', {
        '': lambda: {name: [_sample(viewers)] for name, viewers in VIEWERS.items()}}, (
            Column('CPU of a core', 'page_share', '{:.1%}'),
            Column('pictures to a viewer, Hz', 'viewers_hz', '{:.1f}'),
            Column('latency of recognition, ms', 'latency_ms', has_ratio=True)))
