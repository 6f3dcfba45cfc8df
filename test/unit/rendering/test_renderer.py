"""The renderer is made when it is needed; without its libraries there is a clear error."""
import subprocess
import sys

import pytest

from img_recog.rendering import renderer
from img_recog.rendering.errors import OpenGLError
from img_recog.rendering.opengl import Renderer

# imports what a node and replay.py import before anything is drawn
LOADED = ('import sys, img_recog.nodes.gazebo.node, img_recog.replay.robot_frames; '
          'sys.exit(str({"moderngl", "trimesh"} & set(sys.modules)))')


def test_it_draws_by_opengl():
    assert isinstance(renderer.make(), Renderer)


@pytest.mark.parametrize('library', ['moderngl', 'trimesh'])
def test_a_library_that_is_missing_is_an_error_that_names_it(monkeypatch, library):
    for name in [name for name in sys.modules if name.startswith('img_recog.rendering')]:
        if name != renderer.__name__:
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(OpenGLError) as error:
        renderer.make()
    assert 'moderngl or trimesh cannot be loaded: import of {} halted'.format(library) in str(
        error.value)
    assert '\n' not in str(error.value)


def test_its_libraries_are_not_loaded_before():
    result = subprocess.run([sys.executable, '-c', LOADED], stderr=subprocess.PIPE,
                            universal_newlines=True)
    assert result.stderr.strip().splitlines()[-1] == 'set()'
