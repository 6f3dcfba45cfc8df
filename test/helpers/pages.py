"""The Markdown pages of the project, read as far as the tests need them."""
import glob
import importlib
import os
import re
import sys
import types
from typing import Any, Dict, List, NamedTuple

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
LAUNCH_FOLDER = os.path.join(ROOT, 'launch')
_HEADING = re.compile(r'^(#+) (.*)$')
_FENCED = re.compile(r'^```.*?^```$', re.MULTILINE | re.DOTALL)


class Table(NamedTuple):
    """A table: the headings that it is below, its head, and its rows of cells."""

    chapter: str
    section: str
    head: List[str]
    rows: List[List[str]]


def paths() -> List[str]:
    """Return all pages, relative to the root."""
    return ['README.md', 'README.ja.md', 'CONTRIBUTING.md', *sorted(
        os.path.relpath(path, ROOT) for path in glob.glob(
            os.path.join(ROOT, 'doc', '**', '*.md'), recursive=True))]


def read(path: str) -> str:
    """Return the text of a file, given relative to the root."""
    with open(os.path.join(ROOT, path), encoding='utf-8') as file:
        return file.read()


def tables(text: str) -> List[Table]:
    """Return the tables of a page, each with the headings of level 2 and 3 above it."""
    found, chapter, section, is_open = [], '', '', False
    for line in text.splitlines():
        heading = _HEADING.match(line)
        if heading:
            level, words = len(heading.group(1)), heading.group(2)
            chapter, section = (words, '') if level <= 2 else (chapter, words)
        is_row = line.startswith('|')
        if is_row:
            cells = [cell.strip() for cell in line.strip().strip('|').split('|')]
            if not is_open:
                found.append(Table(chapter, section, cells, []))
            elif set(line) - set('|-'):
                found[-1].rows.append(cells)
        is_open = is_row
    return found


def rows(text: str, chapter: str, first: str) -> List[List[str]]:
    """Return the rows of all tables in a chapter whose first column is called `first`."""
    return [row for table in tables(text) if table.chapter == chapter and table.head[0] == first
            for row in table.rows]


def anchors(text: str) -> List[str]:
    """Return what links to the headings of a page end with, as GitHub and Sphinx make it.

    Not for headings that a page has twice: their numbers depend on the version of myst_parser.
    """
    slugs = [re.sub(r'[^\w\- ]', '', heading.group(2).lower()).replace(' ', '-') for heading in
             filter(None, map(_HEADING.match, _FENCED.sub('', text).splitlines()))]
    return [slug for slug in slugs if slugs.count(slug) == 1]


def links(text: str) -> List[str]:
    """Return the targets of the links and images of a page, but for those at other places."""
    return [target for target in re.findall(r'\]\(([^)\s]+)\)', text) if '://' not in target]


def code(text: str) -> List[str]:
    """Return what a page shows as code: spans, and the lines of indented blocks."""
    text = _FENCED.sub('', text)
    lines = [re.sub(r'\s+#\s.*', '', line).strip() for line in text.splitlines()
             if line.startswith('    ')]
    spans = re.findall(r'`([^`]+)`', re.sub(r'^    .*$', '', text, flags=re.MULTILINE))
    return lines + [' '.join(span.split()) for span in spans]


def launch_arguments(file: str = 'demo.launch') -> Dict[str, Any]:
    """Return the arguments that a launch file takes, with those of its parts, by name."""
    tools = tool('launch_files')
    return tools.taken(tools.with_parts(os.path.join(LAUNCH_FOLDER, file)))


def tool(name: str) -> types.ModuleType:
    """Return a module of tools/."""
    sys.path.append(os.path.join(ROOT, 'tools'))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop()
