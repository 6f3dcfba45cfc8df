"""The texts of the page, and which language is chosen."""
import pathlib
import re
import string

import pytest

from img_recog.nodes.web import page, page_texts

WEB = pathlib.Path(page.__file__).parent


@pytest.mark.parametrize('accepted, language', [
    ('', 'en'), ('ja', 'ja'), ('ja-JP,ja;q=0.9,en-US;q=0.8', 'ja'),
    ('en-US,en;q=0.9,ja;q=0.8', 'en'),
    ('de-DE,de;q=0.9,ja;q=0.5,en;q=0.3', 'ja'), ('de', 'en'), ('ja;q=x', 'en'), ('*', 'en'),
    ('JA', 'ja'), ('ja;q=0', 'en'), (',' * 1000, 'en')])
def test_the_language_of_a_browser(accepted, language):
    assert page_texts.language_of(accepted) == language


def test_both_languages_have_the_same_fields():
    def fields(text):
        return [name for _, name, _, _ in string.Formatter().parse(text) if name is not None]
    english, japanese = (page_texts.Texts(language).all for language in page_texts.LANGUAGES)
    for key, text in english.items():
        assert fields(text) == fields(japanese[key]), key
        assert re.search('[\u3040-\u30ff\u4e00-\u9fff]', japanese[key]), key


def test_every_text_is_used_and_every_used_text_exists():
    sources = '\n'.join(path.read_text() for path in [*WEB.glob('*.py'), *WEB.glob('static/*.js')])
    known = set(page_texts.TABLE)
    quoted = set(re.findall("'([a-z_]+)'", sources))
    assert known <= quoted, 'unused: {}'.format(sorted(known - quoted))
    used = set(re.findall(r"(?:_t|\btexts?)\('([a-z_]+)'", sources))
    assert used and used <= known, 'missing: {}'.format(sorted(used - known))
