"""Configuration of Sphinx; doc/build calls it."""
import re

project = 'img_recog'
author = 'img_recog maintainers'
copyright = author
extensions = ['myst_parser', 'sphinx.ext.autodoc', 'sphinx.ext.viewcode']
source_suffix = {'.md': 'markdown', '.rst': 'restructuredtext'}
root_doc = 'index'
# doc/contents.rst is here as index.rst
exclude_patterns = ['bench', 'config', 'doc/contents.rst', 'launch', 'src', 'test', 'urdf']

myst_heading_anchors = 3
smartquotes = False         # options are written with two hyphens
html_theme = 'alabaster'
html_theme_options = {'page_width': '1300px', 'body_max_width': '1050px'}
html_show_copyright = False
autodoc_member_order = 'bysource'
autodoc_typehints = 'signature'
add_module_names = False

# What starts a new item in a docstring: "name, name: ...", or one of these words.
_NAMES = re.compile(r'([\w*]+(?:, [\w*]+)*)(?=(?: \([^)]*\))?: )')
_WORDS = re.compile(r'(?:Raises|Returns|Publishes|Subscribes|Serves|Reads)\b')
_CODE = re.compile(r'`([^`]+)`')
_MARKUP = re.compile(r'([\\*_|<>`])')


def setup(app):
    """Register the hooks for docstrings."""
    app.connect('autodoc-process-docstring', _make_rest)
    app.connect('autodoc-skip-member', _is_generated)


def _make_rest(_app, _what, _name, _object, _options, lines):
    """Make reST of a docstring, which is plain text: paragraphs, items, and `code`."""
    paragraphs = [[]]
    for line in lines:
        text = line.strip()
        if not text or _WORDS.match(text):
            paragraphs.append([])
        elif _NAMES.match(text):
            paragraphs.append([])
            text = _NAMES.sub(r'`\1`', text, 1)
        if text:
            paragraphs[-1].append(text)
    lines[:] = []
    for paragraph in filter(None, paragraphs):
        lines += [_escaped(' '.join(paragraph)), '']


def _escaped(text):
    # odd parts are those between backquotes
    parts = [part if number % 2 else _MARKUP.sub(r'\\\1', part)
             for number, part in enumerate(_CODE.split(text))]
    text = ''.join('``{}``'.format(part) if number % 2 else part
                   for number, part in enumerate(parts))
    return text if text[0].isalnum() or text[0] == '`' else '\\' + text


def _is_generated(_app, _what, _name, member, skip, _options):
    """Skip the fields of named tuples, whose docstrings Python made."""
    return True if str(getattr(member, '__doc__', '')).startswith('Alias for field') else skip
