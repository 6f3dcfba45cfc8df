"""The page as a browser gets it, with stand-ins for the robot and the system."""
from types import SimpleNamespace

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient
from nicegui import Client, ui

from img_recog.nodes.web import page, page_texts
from img_recog.nodes.web.page_elements import Shared
from img_recog.nodes.web.shown_robots import PictureTopic
from img_recog.nodes.web.tabs import Tab
from img_recog.teleoperation import VelocityLimits


def add_sonar(visit):
    ui.label('{} of {}'.format(visit.texts('distance'), visit.robot.name))


def serve_sonar(app):
    @app.get('/sonar.svg')
    def sonar():
        return 'echo'


SONAR = Tab('sonar', add_sonar, serve=serve_sonar)
SONAR_TEXTS = {'sonar': ['Sonar', 'ソナー'], 'distance': ['Distance', '距離']}


@pytest.fixture(scope='module')
def client():
    """A client of an application with the page and SONAR; NiceGUI can serve only one."""
    limits = VelocityLimits()
    robot = SimpleNamespace(
        name='tb3_1', resolve='/tb3_1/{}'.format, pose=None,
        colors=SimpleNamespace(revision=0, values=dict),
        picture_topics=lambda: [PictureTopic('/usb_cam/image_raw', 'camera')],
        driving=SimpleNamespace(settings=limits, limits=vars(limits), limit=print),
        navigation=SimpleNamespace(has_map=False))
    robots = SimpleNamespace(names=['tb3_1'], seen=set(), get=lambda name: robot)
    app = FastAPI()
    with pytest.MonkeyPatch().context() as monkeypatch:
        monkeypatch.setattr(page, 'TABS', (*page.TABS, SONAR))
        monkeypatch.setattr(page_texts, 'TABLE', {**page_texts.TABLE, **SONAR_TEXTS})
        page.build(app, Shared(robots, robot.colors, SimpleNamespace(path='')))
        with TestClient(app) as client:
            yield client


def test_a_tab_is_a_row_of_the_table(client):
    text = client.get('/', headers={'accept-language': 'ja'}).text
    assert client.get('/sonar.svg').json() == 'echo'
    for words in ('/static/sonar.js', 'ソナー', '距離 of tb3_1', '/static/live.js'):
        assert words in text


def test_only_the_newest_pages_wait_for_their_browser(client):
    before = set(Client.instances)      # of other tests of this process
    for _ in range(22):
        assert client.get('/').status_code == 200
    assert len(set(Client.instances) - before) == 20
