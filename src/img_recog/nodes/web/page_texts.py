"""The texts of the page in English and Japanese."""
from typing import Any, Dict, Mapping, Tuple

LANGUAGES = ('en', 'ja')
DEFAULT = 'en'
TextTable = Mapping[str, Tuple[str, str]]       # by their keys: English, Japanese
# of all tabs; the others are in the modules of the tabs
COMMON: TextTable = {
    'title': ('img_recog: a camera drives a robot', 'img_recog: カメラでロボットを動かす'),
    'robot': ('Robot', 'ロボット'),
    'camera': ('Camera', 'カメラ'),
    'mask': ('{}: recognized pixels', '{}: 認識した画素'),
    'view': ('Simulator', 'シミュレータ'),
    'robot_camera': ('Camera of the robot', 'ロボットのカメラ'),
    'no_image': ('no image yet', '画像がまだありません'),
    'age': ('last image {} s ago', '最後の画像は {} 秒前'),
    'connected': ('connected', '接続中'),
    'disconnected': ('not connected', '未接続'),
    'connection_lost': ('Connection lost.', '接続が切れました。'),
    'reconnecting': ('Trying to reconnect...', '再接続しています...')}


def language_of(accepted: str) -> str:
    """Return the language for the value of the HTTP header Accept-Language, one of LANGUAGES."""
    best, best_weight = DEFAULT, 0.0
    for part in accepted.split(',')[:20]:
        name, _, weight_text = part.partition(';q=')
        try:
            weight = float(weight_text) if weight_text else 1.0
        except ValueError:
            continue
        language = name.strip().lower().split('-')[0]
        if language in LANGUAGES and weight > best_weight:
            best, best_weight = language, weight
    return best


class Texts:
    """The texts in a language, one of LANGUAGES. all: by their keys."""

    def __init__(self, language: str, *tables: TextTable):
        """Choose the texts of the language."""
        column = LANGUAGES.index(language)
        self.language = language
        self.all: Dict[str, str] = {key: pair[column] for table in tables
                                    for key, pair in table.items()}

    def __call__(self, key: str, *values: Any) -> str:
        """Return a text, with these values in it."""
        return self.all[key].format(*values)
