"""The texts of the page in English and Japanese."""
from typing import Any, Dict, Tuple

DEFAULT = 'en'
# key: English, Japanese
_TEXTS: Dict[str, Tuple[str, str]] = {
    'title': ('img_recog: a camera drives a robot', 'img_recog: カメラでロボットを動かす'),
    'live': ('Live', 'ライブ'),
    'colors': ('Colors', '色'),
    'graph': ('Graph', 'グラフ'),
    'nodes': ('Nodes', 'ノード'),
    'log': ('Log', 'ログ'),
    'robot': ('Robot', 'ロボット'),
    'camera': ('Camera', 'カメラ'),
    'mask': ('{}: recognized pixels', '{}: 認識した画素'),
    'view': ('Simulator', 'シミュレータ'),
    'robot_camera': ('Camera of the robot', 'ロボットのカメラ'),
    'no_image': ('no image yet', '画像がまだありません'),
    'age': ('last image {} s ago', '最後の画像は {} 秒前'),
    'map': ('Map', '地図'),
    'map_help': ('Click: move the robot here. Drag: also set its heading.',
                 'クリック: ロボットをここへ移動。ドラッグ: 向きも指定。'),
    'map_label': ('Map of the world with robot, path and laser scan',
                  'ロボット、経路、レーザスキャンを示す地図'),
    'position': ('Position', '位置'),
    'heading': ('Heading', '向き'),
    'drive': ('Drive', '操縦'),
    'drive_help': ('Hold a button, or the keys W A X D or the arrows; S stops. Let go to '
                   'stop; 0.5 s later, the colors command again.',
                   'ボタン、または W A X D・矢印キーを押している間だけ動きます。S は停止です。'
                   '離すと止まり、0.5 秒後に色による指令に戻ります。'),
    'forward': ('Forward', '前進'),
    'backward': ('Backward', '後退'),
    'left': ('Turn left', '左旋回'),
    'right': ('Turn right', '右旋回'),
    'stop': ('Stop', '停止'),
    'max_linear': ('Highest speed (m/s)', '最高速度 (m/s)'),
    'max_angular': ('Highest turn rate (rad/s)', '最高旋回速度 (rad/s)'),
    'areas': ('Areas of the colors (pixels); dashed: limits', '色の面積（画素数）。破線はしきい値'),
    'speeds': ('Speed (m/s)', '速度 (m/s)'),
    'asked': ('asked', '指令'),
    'driven': ('driven', '実際'),
    'seconds': ('Time (s); now is 0', '時間 (秒)、現在は 0'),
    'simulation': ('Simulation', 'シミュレーション'),
    'pause': ('Pause', '一時停止'),
    'paused': ('paused', '一時停止中'),
    'resume': ('Resume', '再開'),
    'reset_world': ('Back to the start', 'スタートに戻す'),
    'viewpoint': ('Viewpoint', '視点'),
    'above': ('from above', '上から'),
    'follow': ('behind the robot', 'ロボットの後ろから'),
    'factor': ('Real time factor', '実時間比'),
    'measured_factor': ('Measured real time factor', '実時間比の実測値'),
    'fastest': ('as fast as possible', '最速'),
    'record': ('Record', '記録'),
    'stop_recording': ('Stop recording', '記録を終了'),
    'recording_to': ('Recording to {}', '{} に記録中'),
    'recorded': ('Recorded: {}', '記録しました: {}'),
    'hue_min': ('Lowest hue (0 to 180)', '色相の下限 (0〜180)'),
    'hue_max': ('Highest hue (0 to 180)', '色相の上限 (0〜180)'),
    'saturation_min': ('Lowest saturation (0 to 255)', '彩度の下限 (0〜255)'),
    'saturation_max': ('Highest saturation (0 to 255)', '彩度の上限 (0〜255)'),
    'value_min': ('Lowest value (0 to 255)', '明度の下限 (0〜255)'),
    'value_max': ('Highest value (0 to 255)', '明度の上限 (0〜255)'),
    'area_limit': ('Command above (pixels)', '指令を出す面積の下限（画素数）'),
    'linear_x': ('Speed (m/s)', '速度 (m/s)'),
    'angular_z': ('Turn rate (rad/s)', '旋回速度 (rad/s)'),
    'pick': ('Choose a color here, then click it in the camera picture: that sets its bounds.',
             'ここで色を選び、カメラ画像でその色をクリックすると、範囲が設定されます。'),
    'proposed': ('Bounds of {} from the picture: hue {} to {}', '{} の範囲を画像から設定: 色相 {}〜{}'),
    'save': ('Save as a file', 'ファイルに保存'),
    'saved': ('Saved. To use it: ./run demo colors:={}', '保存しました。使い方: ./run demo colors:={}'),
    'no_recognition': ('The node color_extract does not answer.',
                       'ノード color_extract が応答しません。'),
    'level': ('From level', '表示する最低レベル'),
    'leaves': ('Topics without subscribers too', '購読されていないトピックも表示'),
    'graph_label': ('Graph of nodes and topics', 'ノードとトピックのグラフ'),
    'node': ('Node', 'ノード'),
    'state': ('State', '状態'),
    'rates': ('Rates', '周波数'),
    'connected': ('connected', '接続中'),
    'disconnected': ('not connected', '未接続'),
    'connection_lost': ('Connection lost.', '接続が切れました。'),
    'reconnecting': ('Trying to reconnect...', '再接続しています...'),
    'busy': ('Another page drives or has stopped the robot: let go, and press again.',
             '別のページがロボットを操縦しているか停止させました。一度離してから、もう一度押してください。'),
}

LANGUAGES = ('en', 'ja')


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

    def __init__(self, language: str):
        """Choose the texts of the language."""
        column = LANGUAGES.index(language)
        self.language = language
        self.all: Dict[str, str] = {key: pair[column] for key, pair in _TEXTS.items()}

    def __call__(self, key: str, *values: Any) -> str:
        """Return a text, with these values in it."""
        return self.all[key].format(*values)
