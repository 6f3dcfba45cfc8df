"""What draws is made when it is needed; without its libraries there is a clear reason."""
import os
import subprocess
import sys

import pytest

from img_recog.errors import UserError
from img_recog.rendering import opengl, renderer

# imports what a node and replay.py import before anything is drawn
LOADED = ('import sys, img_recog.nodes.gazebo.gazebo_node, img_recog.replay.robot_frames; '
          'sys.exit(str({"moderngl", "trimesh"} & set(sys.modules)))')
MADE = '''
import sys
from img_recog.errors import UserError, one_line
from img_recog.rendering import renderer
try:
    renderer.make()
except UserError as error:
    sys.exit(one_line(error))
'''


def test_it_draws_by_opengl():
    assert isinstance(renderer.make(), opengl.Renderer)


def test_without_opengl_there_is_one_line():
    result = subprocess.run([sys.executable, '-c', MADE], stderr=subprocess.PIPE,
                            env={**os.environ, '__EGL_VENDOR_LIBRARY_FILENAMES': '/no_such_file'},
                            universal_newlines=True)
    line, = result.stderr.splitlines()
    assert line.startswith('no OpenGL 3.3 without a display: ')
    assert line.endswith('; install libegl1 and libgl1-mesa-dri')


def test_a_library_that_is_missing_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.startswith('img_recog.rendering')]:
        if name != renderer.__name__:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, 'moderngl', None)
    with pytest.raises(UserError, match='moderngl cannot be loaded: import of moderngl halted'):
        renderer.make()


def test_its_libraries_are_not_loaded_before():
    result = subprocess.run([sys.executable, '-c', LOADED], stderr=subprocess.PIPE,
                            universal_newlines=True)
    assert result.stderr.strip().splitlines()[-1] == 'set()'
