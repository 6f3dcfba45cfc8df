"""What is made of an SDF or a URDF, whole: files of test/expected/models have texts of them."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog import model
from img_recog.formats import sdf_file
from img_recog.formats.problems import Problems
from img_recog_helpers import expected, printed
from img_recog_helpers.sdf import sdf

# of a WorldFile, what is printed apart, or is empty until problems are added
APART = 'trees', 'lights', 'has_floor', 'missing_looks', 'left_out', 'findings'
FILES = 'a.stl', 'b.DAE', 'a.ply', 'a.tif', 'folder/a.stl'


@pytest.fixture
def find(tmp_path):
    """A function that finds the files, and is for `Problems`."""
    for name in FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text('')

    def path_of(uri):
        path = tmp_path / uri.partition('://')[2]
        return str(path) if path.exists() else None
    return path_of


@pytest.mark.parametrize('name', ['sdf_models', 'sdf_shapes'])
def test_of_an_sdf(find, tmp_path, name):
    def read(text):
        problems = Problems()
        root = ElementTree.fromstring(text if text.startswith('<sdf') else sdf(text))
        world = sdf_file.read(root, str(tmp_path / 'w.sdf'), find, problems)
        return '\n'.join([
            *printed.fields(world, *APART)[1:],
            *('light ' + printed.text(light) for light in world.lights),
            *(line for tree in world.trees for line in printed.tree(tree)),
            *('left out: ' + problem for problem in problems.names),
            *('not found: ' + look for look in problems.looks),
            *('{}: {}'.format(finding.state, finding.text()) for finding in problems.findings)]
        ).replace(str(tmp_path), '')
    expected.check_cases('models/{}.txt'.format(name), read)


def test_what_is_as_by_default():
    """It is left out above."""
    expected.check_printed('models/defaults.txt', ''.join(
        '{} {}\n'.format(name, printed.text(kind._field_defaults))
        for name, kind in sorted(vars(model).items())
        if isinstance(kind, type) and getattr(kind, '_field_defaults', None)))
