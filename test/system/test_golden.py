"""What is made of robots and worlds is what it was when test/golden.txt was written."""
import importlib
import os

import pytest

from img_recog_helpers.pages import ROOT


@pytest.fixture
def hashes(monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(ROOT, 'tools'))
    return importlib.import_module('golden')


def test_own_files(hashes):
    # tools/golden.py --compare FOLDER compares the others, with clones of their repositories
    own = [each for each in hashes.read() if each.repository == '.']
    assert len(own) >= 3 and len(hashes.read()) >= len(own) + 20
    assert hashes.of_now(own) == own


def test_a_file_that_differs_or_is_not_there_is_named(hashes, tmp_path):
    own = hashes.read()[0]
    other = own._replace(repository='a/b', path='c.world')
    known, gone = hashes.of_now([own._replace(hash='0'), other], str(tmp_path))
    assert known == own
    assert gone.place == 'a+b/c.world' and gone.hash not in (own.hash, 'not read')
