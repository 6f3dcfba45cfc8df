"""What is made of an SDF or a URDF, whole: files of test/expected/models have texts of them."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog import model
from img_recog.formats import sdf_file
from img_recog.report import Report
from img_recog_helpers import expected, printed
from img_recog_helpers.parsed import given, lumped
from img_recog_helpers.sdf import sdf

# fields of a WorldFile that are printed apart, or empty until findings are added
APART = 'trees', 'lights', 'has_floor', 'findings'


@pytest.fixture
def find(tmp_path):
    """A function that finds all files but those that are called none."""
    (tmp_path / 'folder').mkdir()

    def path_of(uri):
        name = uri.partition('://')[2]
        if not name or 'none' in name or '/' in name:
            return None
        path = tmp_path / name
        if not path.exists():
            path.write_text('')
        return str(path)
    return path_of


@pytest.mark.parametrize('name', ['sdf_models', 'sdf_shapes'])
def test_of_an_sdf(find, tmp_path, name):
    def read(text):
        report = Report()
        root = ElementTree.fromstring(text if text.startswith('<sdf') else sdf(text))
        world = sdf_file.read(root, str(tmp_path / 'w.sdf'), find, report)
        return '\n'.join([
            *printed.fields(world, *APART)[1:],
            *('light ' + printed.text(light) for light in world.lights),
            *(line for tree in world.trees for line in printed.tree(tree)),
            *printed.findings(report)]
        ).replace(str(tmp_path), '')
    expected.check_cases('models/{}.txt'.format(name), read)


@pytest.mark.parametrize('name, read', [('urdf_links', given), ('urdf_robots', lumped)])
def test_of_a_urdf(find, tmp_path, name, read):
    def robot(text):
        report = Report()
        model = read(text, find, report)
        return '\n'.join(['robot ' + model.name, *printed.model(model),
                          *printed.findings(report)]).replace(str(tmp_path), '')
    expected.check_cases('models/{}.txt'.format(name), robot)


def test_what_is_as_by_default():
    """It is left out above."""
    expected.check_printed('models/defaults.txt', ''.join(
        '{} {}\n'.format(name, printed.text(kind._field_defaults))
        for name, kind in sorted(vars(model).items())
        if isinstance(kind, type) and getattr(kind, '_field_defaults', None)))
