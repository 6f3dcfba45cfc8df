"""The schema of SDF and URDF, and the reader of values."""
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.errors import SimulationError
from img_recog.formats import reader, schema
from img_recog.formats.reader import value

TYPED = [(path, name, child) for table in (schema.SDF, schema.URDF)
         for path, row in table.items()
         for name, child in schema.children_of(row).items() if child.type]


def test_each_default_is_a_value_of_its_type():
    for path, name, child in TYPED:
        if child.default is not None:
            reader.read(child.type, child.default.replace(',', ' '), path + '/' + name)
        else:
            reader.type_of(child.type)


@pytest.mark.parametrize('kind, text, found', [
    ('number', '1.5 2', 1.5), ('number', ' 1e300 ', 1e30), ('share', '-1', 0.0),
    ('positive', '-2', 0.0), ('limit', '-inf', float('-inf')), ('whole', '0x1f', 31),
    ('bits', '0x1ffff', 0xffff), ('friction', '-1', 100.0), ('friction', '0.3', 0.3),
    ('bool', 'TRUE', True), ('bool', 'maybe', False), ('text', ' a b ', 'a b'),
    ('color', '255 0 0', (1.0, 0.0, 0.0, 1.0)), ('color', '0 0.5 1 0.2', (0.0, 0.5, 1.0, 0.2))])
def test_a_text_is_read_by_its_type(kind, text, found):
    assert reader.read(kind, text, 'x') == found


@pytest.mark.parametrize('kind, text', [
    ('number', ''), ('number', 'nan'), ('number', 'inf'), ('number', 'x'), ('limit', 'nan'),
    ('whole', 'x'), ('count', '5001'), ('count', '-1'), ('length', '2e6'), ('size', '0'),
    ('3sizes', '1 0 1'), ('3lengths', '1 2'), ('3numbers', '1 2 3 4'), ('3numbers', 'nan 0 0'),
    ('direction', '0 0 0'), ('axis', '0 0 0'), ('color', '1 1'), ('bits', 'x'),
    ('coefficient', '-0.1')])
def test_a_text_that_is_not_of_its_type_is_refused(kind, text):
    with pytest.raises(SimulationError) as error:
        reader.read(kind, text, '<a> of link b')
    assert error.value.problem == '<a> of link b: got {!r}, expected {}'.format(
        text, reader.type_of(kind).allowed)


def test_a_message_names_the_element():
    link = ElementTree.fromstring('<link name="a"><inertial><mass>x</mass></inertial></link>')
    with pytest.raises(SimulationError, match="<mass> of link a: got 'x', expected a finite"):
        value(link, 'inertial/mass')
    with pytest.raises(SimulationError, match='<mass> of link m::a: '):
        value(link, 'inertial/mass', 'link m::a')


def test_a_value_without_a_default_can_be_required():
    box = ElementTree.fromstring('<box/>')
    assert value(box, 'size') is None
    with pytest.raises(SimulationError, match='<size> of collision c: got None, expected 3 '):
        reader.required(box, 'size', 'collision c')
