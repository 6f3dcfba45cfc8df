"""Whether windows can be shown."""
import os
import subprocess
import sys

from img_recog.errors import shortened

_TIMEOUT_S = 10.0           # of a display on another host
_NO_SERVER = 3
# in a process: the library may block, and writes to stderr; three times: Xvfb resets itself when
# its last client leaves, and refuses clients meanwhile
_OPEN = ('import ctypes, sys, time; x = ctypes.CDLL("libX11.so.6"); x.XOpenDisplay.restype = '
         'ctypes.c_void_p; sys.exit(0 if any(x.XOpenDisplay(None) or time.sleep(0.3) '
         'for _ in range(3)) else {})'.format(_NO_SERVER))


def problem() -> str:
    """Return why no window can be opened, '' if one can as far as is known."""
    name = os.environ.get('DISPLAY', '')
    if not name:
        return 'there is no display'
    try:
        code = subprocess.call([sys.executable, '-c', _OPEN], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, timeout=_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        code = _NO_SERVER
    return 'no X server can be used at DISPLAY={}'.format(shortened(name)) * (code == _NO_SERVER)
