"""The texts of the page in English and Japanese, from page_texts.txt."""
import pathlib
from typing import Any, Dict

from img_recog.command_line.messages import entries

LANGUAGES = ('en', 'ja')
DEFAULT = 'en'
# by their keys, in the order of LANGUAGES
TABLE = {key: texts for key, *texts in entries(pathlib.Path(__file__).with_suffix('.txt'))}


def language_of(accepted: str) -> str:
    """Return the language for the value of the HTTP header Accept-Language, one of LANGUAGES."""
    best, best_weight = DEFAULT, 0.0
    for part in accepted.split(',')[:20]:
        name, _, weight_text = part.partition(';q=')
        try:
            weight = float(weight_text) if weight_text else 1.0
        except ValueError:
            continue
        language = name.strip().lower().split('-')[0]
        if language in LANGUAGES and weight > best_weight:
            best, best_weight = language, weight
    return best


class Texts:
    """The texts in a language, one of LANGUAGES. all: by their keys."""

    def __init__(self, language: str):
        """Choose the texts of the language."""
        column = LANGUAGES.index(language)
        self.language = language
        self.all: Dict[str, str] = {key: texts[column] for key, texts in TABLE.items()}

    def __call__(self, key: str, *values: Any) -> str:
        """Return a text, with these values in it."""
        return self.all[key].format(*values)
