"""XML and YAML of others: hostile files are one line each, wherever they are read."""
import os
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.camera import calibration
from img_recog.formats import markup, model_file, world_file
from img_recog.formats.yaml_text import load_yaml
from img_recog.loading import robot_file
from img_recog.recognition import parameter_file
from img_recog.report import Report
from img_recog.simulation.configured_model import from_urdf
from img_recog_helpers.parsed import lumped
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import burger

LAUGHS = ('<!DOCTYPE robot [<!ENTITY a "ha">'
          + ''.join('<!ENTITY {} "{}">'.format(name, '&{};'.format(other) * 10)
                    for other, name in zip('abcdefghi', 'bcdefghij')) + ']><robot>&j;</robot>')
DEEP = '<robot name="r">{}{}</robot>'.format('<a>' * 200000, '</a>' * 200000)
MANY_ATTRIBUTES = ''.join(' b{}=""'.format(number) for number in range(1000))
LONG_COMMENT = '<!--{}-->'.format('x' * ((1 << 22) - len('!--') - len('-->') - 1))
HOSTILE_XML = {
    'deep': (DEEP, 'nested too deeply: more than 100 levels at line 1'),
    'deep without an end': ('<robot>' * 200000, 'nested too deeply'),
    'laughs': (LAUGHS, 'it declares entities, which are not supported'),
    'foreign entity': ('<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/hostname">]>'
                       '<robot name="&x;"/>', 'it declares entities'),
    'attribute': ('<robot\nname="{}"/>'.format('x' * 3000000),
                  'attribute name at line 1 has 3000000 characters, allowed are 10000'),
    'attribute name': ('<robot {}="1">'.format('x' * 3000000), 'not XML'),
    'text': ('<robot>{}</robot>'.format('x' * 3000000),
             'a text before line 2 has more than 100000 characters'),
    'elements': ('<robot>\n' + '<a/>' * 200000,
                 'more than 200000 elements or 400000 attributes at line 2'),
    'attributes': ('<robot>\n' + ('<a' + MANY_ATTRIBUTES + '/>') * 401,
                   'more than 200000 elements or 400000 attributes at line 2'),
    'attributes of an element': ('<robot>\n<a{} a=""/>'.format(MANY_ATTRIBUTES),
                                 'an element at line 2 has 1001 attributes, allowed are 1000'),
    'endless tag': ('<robot>\n<a' + ' b="1"' * 800000 + '/></robot>',
                    'a tag, comment or text at line 2 has more than 4194304 characters'),
    'NUL': ('<robot>\0</robot>', 'not XML: not well-formed (invalid token): line 1'),
    'empty': ('', 'not XML: it is empty, or ends at line 1 before the root element is complete'),
    'tag that is not closed': ('<robot' + ' ' * 3000000, 'not XML'),
    'surrogate': ('<robot name="\ud800"/>', 'not XML'),
}


@pytest.mark.parametrize('text, words', list(HOSTILE_XML.values()), ids=list(HOSTILE_XML))
def test_hostile_xml_is_one_line(text, words):
    assert words in refusal(markup.parse_xml, text)


@pytest.mark.parametrize('name', ['laughs', 'NUL', 'surrogate'])
def test_hostile_xml_is_one_line_wherever_it_is_read(tmp_path, name):
    text, words = HOSTILE_XML[name]
    assert words in refusal(lumped, text)
    line = refusal(from_urdf, text, 0.001, lambda uri: None, 'robot_description')
    assert line.startswith('cannot use the robot in robot_description: ') and words in line
    for file in ('robot.world', 'robot.xacro'):
        (tmp_path / file).write_bytes(text.encode('utf-8', 'surrogatepass'))
    line = refusal(world_file.read, str(tmp_path / 'robot.world'), {})
    assert str(tmp_path / 'robot.world') in line and words in line
    line = refusal(robot_file.read, str(tmp_path / 'robot.xacro'))
    assert 'robot.xacro: ' in line and (words in line or 'not a text file' in line)


@pytest.mark.parametrize('text', [
    '<robot name="r"><a><b>c</b>d</a><!-- e --></robot>',
    '<robot xmlns:x="http://x" x:name="r"><x:a/></robot>',
    '<?xml version="1.0" encoding="utf-8"?><!DOCTYPE robot><robot name="\u00e9">&lt;</robot>',
    '<a>' * 100 + '</a>' * 100, '<a>{}</a>'.format('<b>{}</b>'.format('x' * 1000) * 200),
    '<a b="{}">{}</a>'.format('x' * 10000, 'x' * 100000),
    '<a>' + '<b/>' * (200000 - 1) + '</a>',
    '<a>' + '<b{}/>'.format(MANY_ATTRIBUTES) * 400 + '</a>', '<a>{}</a>'.format(LONG_COMMENT)],
    ids=['children', 'namespace', 'entities of XML', 'deepest', 'many texts', 'longest',
         'most elements', 'most attributes', 'long comment'])
def test_other_xml_is_read_like_by_elementtree(text):
    expected = ElementTree.tostring(ElementTree.fromstring(text))
    assert ElementTree.tostring(markup.parse_xml(text)) == expected


@pytest.mark.parametrize('text, same', [
    ('\n <?xml version="1.0"?>\n<a/>', '<a/>'),
    ('text<!DOCTYPE a><a>b</a></a> text', '<a>b</a>'),
    ('<a b="c & d">e & f &nbsp; &amp; &#38;</a>',
     '<a b="c &amp; d">e &amp; f &amp;nbsp; &amp; &#38;</a>'),
    ('<!-- a -- b ---><a><!---- c -- & -->d</a>', '<a>d</a>'),
    ('<a b=\'"\'c="<"d=5 e=x/>', '<a b="&quot;" c="&lt;" d="5" e="x"/>'),
    ('<a xmlns:y="z" xmlns:xx="x"><x:b y:c="1"/></a>',
     '<a xmlns:y="z" xmlns:xx="x" xmlns:x="x"><x:b y:c="1"/></a>'),
    ('<a>\x1b&<![CDATA[&<]]></a>', '<a> &amp;<![CDATA[&<]]></a>')],
    ids=['declaration', 'around the root', 'ampersand', 'comments', 'attributes', 'prefixes',
         'control character'])
def test_what_tinyxml_reads_is_read(text, same):
    for each in (text, text.encode(), b'<!-- \xe9 &\n-->' + text.encode()):
        assert ElementTree.tostring(markup.parse_xml(each)) == ElementTree.tostring(
            ElementTree.fromstring(same))


@pytest.mark.parametrize('text, words', [
    ('\n<?xml version="1.0"?>\n<a>', 'XML or text declaration not at start of entity: line 2'),
    ('<a b="&"></b>', 'not well-formed (invalid token): line 1'),
    ('<a b/>', 'not well-formed'), ('<a b="1" b="2"/>', 'duplicate attribute'),
    ('<a>&<!-- </a>', 'not well-formed'), ('<a>& < b</a>', 'not well-formed'),
    ('&' + '<a>' * 101 + '</a>' * 101, 'not well-formed')])
def test_what_tinyxml_refuses_too_has_the_error_of_the_text_itself(text, words):
    assert 'not XML: ' + words in refusal(markup.parse_xml, text)


XACRO = '<robot name="r"><link name="a"/>{}</robot>'


@pytest.mark.parametrize('inside, words', [
    ('<xacro:include filename="b.xacro"/>', '<xacro:include>'),
    ('<a xmlns:x="http://www.ros.org/wiki/xacro"><x:insert_block/></a>',
     '<xacro:insert_block>'),
    ('<joint><origin xyz="0 0 ${half}"/></joint>', '<origin xyz="0 0 ${half}">'),
    ('<link><visual><mesh filename="$(find b)/c.stl"/></visual></link>',
     '<mesh filename="$(find b)/c.stl">')])
def test_xacro_that_is_not_expanded_is_named_wherever_it_is_read(tmp_path, inside, words):
    words = 'it contains xacro ({}), which is not expanded'.format(words)
    path = tmp_path / 'robot.urdf'
    path.write_text(XACRO.format(inside))
    for read, value in ((lumped, path.read_text()), (robot_file.read, str(path))):
        assert words in refusal(read, value)
        assert 'give the file a name that ends with .xacro, or expand it' in refusal(read, value)
    assert words in refusal(world_file.read, str(path), {})
    assert words in refusal(model_file.read, path.read_text(), 'm', lambda uri: None, Report())


def test_old_xacro_that_nothing_expands_is_named():
    line = refusal(lumped, XACRO.format('<include filename="b.xacro"/>'))
    assert line == ('it contains xacro (<include>), which is not expanded; xacro of Noetic '
                    'expands only <xacro:include>')
    # makes nothing, and is left in what others expanded
    text = burger().replace('<link ', '<property name="a" value="1"/><link ', 1)
    report = Report()
    lumped(text, report=report)
    assert report.lines() == []


def test_xacro_that_makes_nothing_is_a_warning():
    text = burger().replace('<link ', '<xacro:property name="a" value="1"/><link ', 1)
    report = Report()
    lumped(text, report=report)
    assert report.lines() == ['it contains xacro (<xacro:property>), which is not expanded']


def test_the_namespace_of_xacro_alone_is_no_xacro(tmp_path):
    path = tmp_path / 'robot.urdf'
    path.write_text('<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro"><gazebo><a b="${c}"/>'
                    '</gazebo></robot>')
    assert robot_file.read(str(path)) == path.read_text()


def test_encodings():
    text = '<?xml version="1.0" encoding="{}"?><robot name="\u00e9"/>'
    for encoding in ('iso-8859-1', 'utf-16', 'utf-8'):
        root = markup.parse_xml(text.format(encoding).encode(encoding))
        assert root.get('name') == '\u00e9'
    assert 'not XML' in refusal(markup.parse_xml, b'<robot name="\xe9"/>')
    # the declaration is checked, whatever the encoding
    assert 'entities' in refusal(markup.parse_xml, LAUGHS.encode('utf-16'))


@pytest.mark.parametrize('kind', ['urdf', 'xacro', 'world', 'yaml'])
def test_files_that_are_too_large(tmp_path, monkeypatch, kind):
    path = tmp_path / ('large.' + kind)
    path.write_bytes(b'')
    os.truncate(str(path), (1 << 24) + 1)
    read = {'world': lambda name: world_file.read(name, {}), 'yaml': parameter_file.read}.get(
        kind, robot_file.read)
    line = refusal(read, str(path))
    assert str(path) in line and 'larger than {} bytes'.format(
        1 << (20 if kind == 'yaml' else 24)) in line


ALIASES = 'a: &a [x, x, x, x, x, x, x, x, x]\n' + ''.join(
    '{1}: &{1} [{0}]\n'.format(', '.join(['*' + other] * 9), name)
    for other, name in zip('abcdefgh', 'bcdefghi'))
HOSTILE_YAML = {
    'deep': '[' * 500, 'deep maps': '{a: ' * 500, 'deep blocks': '- ' * 5000 + 'x',
    'aliases': ALIASES + 'colors: *i\n', 'aliases as a name': ALIASES + '? *i\n: 1\n',
    'only aliases': ALIASES, 'itself': 'colors: &a [*a]\n',
    'map of itself': 'colors: &a {b: *a}\n', 'long text': 'colors: {}\n'.format('x' * 100000),
    'long name': '? {}\n: 1\n'.format('x' * 100000), 'date': 'colors: 2020-01-01\n',
    'empty integer': 'colors: !!int ""\n', 'no date': 'colors: 2020-99-99\n',
    'no timestamp': 'colors: !!timestamp x\n', 'no truth': 'colors: !!bool x\n',
    'code': 'colors: !!python/object/apply:os.system [exit]\n', 'NUL': 'colors: "\0"\n',
    'not text': b'colors: \xff\xfe\n', 'list as a name': '? [a]\n: 1\n',
    'many digits': 'colors: {}\n'.format('9' * 20000),
    'name': '{}: 1\n'.format('x' * 100), 'number as a name': '1: 2\n',
}


@pytest.mark.parametrize('text', list(HOSTILE_YAML.values()), ids=list(HOSTILE_YAML))
def test_hostile_yaml_is_one_line_wherever_it_is_read(tmp_path, text):
    path = tmp_path / 'hostile.yaml'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    assert str(path) in refusal(parameter_file.read, str(path))
    assert str(path) in refusal(calibration.load, str(path))


@pytest.mark.parametrize('text, value', [
    ('deg(120)', 2.0943951), ('!degrees 120.0', 2.0943951), ('!degrees 120', 2.0943951),
    ('rad(2*pi)', 6.2831853), ('!radians pi/2', 1.5707963), ('rad(-1.5)', -1.5),
    ('deg(-90)', -1.5707963), ('degree', 'degree'), ('"deg(5)"', 'deg(5)')])
def test_angles_of_yaml_are_those_of_rosparam(text, value):
    found = load_yaml('a: {}'.format(text).encode())['a']
    assert found == (value if isinstance(value, str) else pytest.approx(value))


@pytest.mark.parametrize('text', [b'deg(x)', b'!degrees [1]', b'rad()', b'rad(1/0)'])
def test_wrong_angles_of_yaml_are_one_line(text):
    assert '\n' not in refusal(load_yaml, text)


def test_an_error_of_yaml_has_its_place():
    problem = refusal(load_yaml, b'- name: a\n  x_pos: [1, 2\n')
    assert problem.startswith('no YAML, line 3, column 1: ') and 'expected' in problem, problem


@pytest.mark.parametrize('text, problem', [
    (b'[' * 1000, 'nested too deeply'),         # for Python
    (b'a: 1\nb: 2\n"a": 3\n', 'a is given twice, in lines 1 and 3'),
    (b'- {x: 1, x: 1}\n', 'x is given twice, in lines 1 and 1'),
    (b'b: &b {c: {d: 1}}\ne: [*b, {c: 1,\n c: 2}]\n', 'c is given twice, in lines 2 and 3'),
    (b'1: a\n2: b\ntrue: c\n', '1 or true is given twice, in lines 1 and 3'),
    (b'1: a\n1.0: b\n', '1 or 1.0 is given twice, in lines 1 and 2'),
    (b'yes: a\non: b\n', 'yes or on is given twice, in lines 1 and 2'),
    (b'16: a\n0x10: b\n', '16 or 0x10 is given twice, in lines 1 and 2'),
    (b'a: &a x\nb: {*a : 1, *a : 2}\n', 'x is given twice, in lines 1 and 1')])
def test_yaml_that_is_refused(text, problem):
    assert refusal(load_yaml, text) == problem


@pytest.mark.parametrize('text, content', [
    (b'1: a\n"1": b\n', {1: 'a', '1': 'b'}),
    (b'a: &a {x: 1, y: 2}\nb: {<<: *a, x: 3}\nc: *a\n',
     {'a': {'x': 1, 'y': 2}, 'b': {'x': 3, 'y': 2}, 'c': {'x': 1, 'y': 2}}),
    (b'- a\n- a\n', ['a', 'a']), (b'', None), (b'7', 7)])
def test_yaml_without_a_key_that_is_given_twice(text, content):
    assert load_yaml(text) == content
