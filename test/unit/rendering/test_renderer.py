"""What draws is made when it is needed; without its libraries there is a clear reason."""
import subprocess
import sys

from img_recog.errors import UserError
from img_recog.rendering import opengl, renderer

# imports what a node and replay.py import before anything is drawn
LOADED = ('import sys, img_recog.nodes.gazebo.node, img_recog.replay.robot_frames; '
          'sys.exit(str({"moderngl", "trimesh"} & set(sys.modules)))')


def test_it_draws_by_opengl():
    made, reason = renderer.make_or(list)
    assert isinstance(made, opengl.Renderer) and reason == ''


def test_without_opengl_something_else_draws(monkeypatch):
    def refuse(self):
        raise UserError('no OpenGL', 'install it')
    monkeypatch.setattr(opengl.Renderer, '__init__', refuse)
    assert renderer.make_or(list) == ([], 'no OpenGL; install it')


def test_a_library_that_is_missing_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.startswith('img_recog.rendering')]:
        if name != renderer.__name__:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, 'moderngl', None)
    made, reason = renderer.make_or(list)
    assert made == [] and '\n' not in reason
    assert 'moderngl cannot be loaded: import of moderngl halted' in reason


def test_its_libraries_are_not_loaded_before():
    result = subprocess.run([sys.executable, '-c', LOADED], stderr=subprocess.PIPE,
                            universal_newlines=True)
    assert result.stderr.strip().splitlines()[-1] == 'set()'
