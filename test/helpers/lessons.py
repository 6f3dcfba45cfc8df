"""The lessons of doc/lessons, read as somebody follows them: what is typed where, and printed.

A page is prose with fenced blocks. `bash` blocks are typed into the terminal that the prose above
names last, as in "terminal 2"; `text` blocks are lines that this terminal then prints, among
others and in any order; all other blocks are files, and the last code span of the prose above is
the path. "Ctrl-C in terminal 2" ends what runs there. A block that begins with ```bash needs
PACKAGE ... is for readers who have these packages of ROS.
"""
import re
from typing import Iterator, List, NamedTuple

_BLOCK = re.compile(r'^```(\w+)(?: needs ([\w ]+))?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_TERMINAL = re.compile(r'(?:[Tt]erminal|ターミナル) (\d)')
_CTRL_C = re.compile(r'Ctrl-C in terminal (\d)|ターミナル (\d) で Ctrl-C')
_NUMBER = re.compile(r'(?<![\w.])-?\d+(?:\.\d+)?(?!\w)')


class Step(NamedTuple):
    """kind: type, read, write or interrupt. where: the terminal, or the path of the file.

    needs: packages of ROS, with spaces between them.
    """

    kind: str
    where: str
    text: str
    needs: str


def steps(page: str) -> List[Step]:
    """Return what a reader of the text of a lesson does."""
    return list(_steps(page))


def _steps(page: str) -> Iterator[Step]:
    terminal, needs, begin = '', '', 0
    for block in _BLOCK.finditer(page + '\n```text\n```'):
        prose, begin = page[begin:block.start()], block.end()
        for numbers in _CTRL_C.findall(prose):
            yield Step('interrupt', ''.join(numbers), '', needs)
        terminal = ([terminal] + _TERMINAL.findall(prose))[-1]
        language, needs, text = block.groups('')
        if language in ('bash', 'text'):
            if text:
                yield Step('type' if language == 'bash' else 'read', terminal, text, needs)
        else:
            yield Step('write', re.findall('`([^`]+)`', prose)[-1], text, needs)


def pattern(line: str) -> str:
    """Return a regular expression for a printed line.

    ... stands for anything, 0 for zero, and any other number for one with its sign.
    """
    parts, begin = [], 0
    for number in _NUMBER.finditer(line):
        parts += [re.escape(line[begin:number.start()]), _any_like(number.group())]
        begin = number.end()
    parts.append(re.escape(line[begin:]))
    return r'(?m)^[ \t]*{}[ \t\r]*$'.format(''.join(parts).replace(re.escape('...'), '.*'))


def _any_like(number: str) -> str:
    if float(number) == 0:
        return r'-?0(?:\.0+)?'
    return ('-' if number.startswith('-') else '') + r'(?!0(?:\.0*)?(?![\d.]))\d[\d.]*'
