"""Files are read once, again when they change, and forgotten when nothing uses them."""
import os

import pytest

from img_recog.rendering.prepared import FileCache


@pytest.fixture
def cache(tmp_path):
    """A cache of texts; `cache.reads`: the names that were read."""
    reads = []

    def read(path):
        reads.append(os.path.basename(path))
        with open(path) as file:
            return file.read()
    made = FileCache(read)
    made.reads = reads
    made.folder = tmp_path
    (tmp_path / 'a').write_text('first')
    (tmp_path / 'b').write_text('second')
    return made


def get(cache, name):
    return cache.get(str(cache.folder / name))


def test_a_file_is_read_once(cache):
    assert [get(cache, 'a'), get(cache, 'b'), get(cache, 'a')] == ['first', 'second', 'first']
    cache.forget_unused()
    assert get(cache, 'a') == 'first' and cache.reads == ['a', 'b']


def test_what_is_not_used_is_forgotten(cache):
    get(cache, 'a')
    cache.forget_unused()
    get(cache, 'b')
    cache.forget_unused()
    assert get(cache, 'a') == 'first' and cache.reads == ['a', 'b', 'a']


@pytest.mark.parametrize('text', ['longer than before', 'FIRST'])
def test_a_file_that_has_changed_is_read_again(cache, text):
    get(cache, 'a')
    (cache.folder / 'a').write_text(text)
    os.utime(str(cache.folder / 'a'), (1, 1))       # whatever the resolution of the clock
    assert get(cache, 'a') == text


def test_an_error_is_raised_each_time(cache):
    for _ in range(2):
        with pytest.raises(FileNotFoundError):
            get(cache, 'missing')
    (cache.folder / 'missing').write_text('here')
    assert get(cache, 'missing') == 'here'


@pytest.mark.parametrize('names', [('none', 'neither'), ('a\0', 'b\0')])
def test_paths_without_a_file_are_told_apart(names):
    cache = FileCache(str.upper)
    assert [cache.get(name) for name in names] == [name.upper() for name in names]
