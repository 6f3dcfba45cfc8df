"""What a page does with the colors of its robot."""
import threading
from types import SimpleNamespace

import yaml

from img_recog import files
from img_recog.nodes.web.robot import Robot


def test_two_robots_save_their_colors_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(files, 'user_folders', lambda: (str(tmp_path),))
    saved = {}

    def save(number):
        robot = Robot.__new__(Robot)
        robot.colors = SimpleNamespace(values=lambda: {'blue_hue_min': number})
        saved[number] = robot.save_colors()
    threads = [threading.Thread(target=save, args=(number,)) for number in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(saved.values())) == 20
    for number, path in saved.items():
        with open(path) as file:
            assert yaml.safe_load(file) == {'colors': ['blue'], 'blue_hue_min': number}
