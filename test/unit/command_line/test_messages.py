"""The table of messages has all those of the programs and no others, with the same values."""
import ast
import pathlib
import re

import pytest

from img_recog.command_line import messages
from img_recog_helpers.pages import ROOT

PROGRAMS = [path for folder in ('src/img_recog', 'tools')
            for path in sorted(pathlib.Path(ROOT, folder).rglob('*.py'))]
SCRIPTS = [pathlib.Path(ROOT, 'run'), *sorted(pathlib.Path(ROOT, 'tools').glob('*.bash'))]


def in_programs():
    for path in PROGRAMS:
        text = path.read_text()
        if 'img_recog.command_line.messages import message' in text:
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.Call) and getattr(node.func, 'id', '') in (
                        'message', 'ArgumentError', 'say', 'refused'):
                    yield from (each.value for each in ast.walk(node.args[0])
                                if isinstance(each, ast.Constant))
    for path in SCRIPTS:
        found = re.findall(r"\b(say|fail|message) '([^']*)'", path.read_text())
        yield from (text for _, text in found)


def test_every_message_is_translated_and_every_translation_used():
    assert set(messages.japanese()) == set(in_programs())


@pytest.mark.parametrize('english', sorted(messages.japanese()))
def test_a_translation_has_the_same_values(english):
    japanese = messages.japanese()[english]
    assert japanese.count('{}') == english.count('{}')
    assert re.search('[\u3040-\u30ff\u4e00-\u9fff]', japanese)
    # commands and names are not translated
    assert sorted(re.findall('"(.+?)"', japanese)) == sorted(re.findall('"(.+?)"', english))


def test_the_language_is_that_of_the_user(monkeypatch):
    monkeypatch.setenv('LC_ALL', 'ja_JP.UTF-8')
    assert messages.message('cannot write in {}: {}', '/x', 'why') == '/x に書き込めません: why'
    assert messages.message('not in the table: {}', 1) == 'not in the table: 1'
    monkeypatch.setenv('LC_ALL', 'C')
    assert messages.message('nothing is wrong') == 'nothing is wrong'
