"""Commands in texts of the package, which a user pastes into a shell: what is put in is quoted."""
import ast
import os
import re

import pytest

from img_recog_helpers.pages import ROOT

# after a colon or in quotes or brackets: a program, its words, and a place for a value
_PROGRAM = r'(sudo |\./run|rosrun|roslaunch|rosbag|rosnode|ffmpeg|xacro|python3 )'
_COMMAND = re.compile(r'(?<!usage)[:"(] ?' + _PROGRAM + r'[^;:"]*\{[0-9]?\}')
_CONSTANT = re.compile(r'[A-Z_]+\b')


def unquoted(source):
    """Yield the lines in which a value is put into a command without shlex.quote."""
    if not re.search(_PROGRAM, source):
        return
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.BinOp) and isinstance(node.left, ast.Constant):
            if isinstance(node.left.value, str) and _COMMAND.search(node.left.value + '{}'):
                added = ast.get_source_segment(source, node.right)
                if not added.startswith('shlex.quote(') and not _CONSTANT.match(added):
                    yield node.lineno
        if not isinstance(node, ast.Call):
            continue
        function, words = node.func, node.args
        if isinstance(function, ast.Attribute) and function.attr == 'format':
            words = [function.value, *words]
        elif getattr(function, 'id', '') != 'message':
            continue
        template = words[0].value if words and isinstance(words[0], ast.Constant) else ''
        if (isinstance(template, str) and _COMMAND.search(template)
                and 'shlex.quote' not in ast.get_source_segment(source, node)):
            yield node.lineno


@pytest.mark.parametrize('source, lines', [
    ("'do: rosbag reindex {}'.format(path)", [1]),
    ("'do: rosbag reindex {}'.format(shlex.quote(path))", []),
    ("'do: rosbag reindex ' + path", [1]),
    ("'do: rosbag reindex ' + shlex.quote(path)", []), ("'do: rosbag record ' + TOPICS[0]", []),
    ("message('\"rosnode kill {}\"', name)", [1]),
    ("'rosbag cannot read: {}'.format(error)", [])])
def test_what_counts(source, lines):
    assert list(unquoted(source)) == lines


def test_values_in_commands_are_quoted():
    found = []
    for folder, _, names in os.walk(os.path.join(ROOT, 'src')):
        for name in names:
            if name.endswith('.py'):
                with open(os.path.join(folder, name), encoding='utf-8') as file:
                    found += ['{}:{}'.format(name, line) for line in unquoted(file.read())]
    assert found == []
