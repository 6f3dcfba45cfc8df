"""The lessons: every command and every file in them, and what is printed, as they say.

A page is prose with fenced blocks. `bash` blocks are typed into the terminal that the prose above
names last, as in "terminal 2"; `text` blocks are lines that this terminal then prints, among
others and in any order; all other blocks are files, and the last code span of the prose above is
the path. "Ctrl-C in terminal 2" ends what runs there. A block that begins with ```bash needs
PACKAGE ... is for readers who have these packages of ROS.
"""
import contextlib
import glob
import os
import pathlib
import re
import signal
from typing import Iterator, List, NamedTuple

import pytest
import rospkg

from img_recog_helpers.ignored import shown
from img_recog_helpers.pages import ROOT, read
from img_recog_helpers.process_table import end_all
from img_recog_helpers.waiting import wait_for

LESSONS = sorted(os.path.basename(path)
                 for path in glob.glob(os.path.join(ROOT, 'doc', 'lessons', '*.md')))
LONGEST_S = 400.0       # of a command, on an idle machine
ROSPY_END_S = 10.0      # until it has ended after Ctrl-C, or never does
_BLOCK = re.compile(r'^```(\w+)(?: needs ([\w ]+))?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
_TERMINAL = re.compile(r'(?:[Tt]erminal|ターミナル) (\d)')
_CTRL_C = re.compile(r'Ctrl-C in terminal (\d)|ターミナル (\d) で Ctrl-C')
# what is typed otherwise here: the environment of the test is already that of this shell, and
# readers with a display have no page
_OTHERWISE = ((r'^\./run shell$', './run shell true'),
              (r'^\./run demo (?!.*web:=)', './run demo web:=false '))


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
    """Return a regular expression for a printed line, in which ... stands for anything."""
    return r'(?m)^[ \t]*{}[ \t\r]*$'.format(re.escape(line).replace(re.escape('...'), '.*'))


class Terminal:
    """A shell of the reader; where it is and what it has sourced stays from block to block."""

    def __init__(self, ros, folder):
        self._ros, self._folder, self._kept = ros, folder, []
        self._program, self._lines, self._begin = None, [], 0

    def type(self, text, is_endless):
        """Run the lines; wait for their end, unless the reader presses Ctrl-C later."""
        assert self._program is None or not self._program.is_running(), 'Ctrl-C is missing'
        for written, typed in _OTHERWISE:
            text = re.sub(written, typed, text, flags=re.MULTILINE)
        self._lines = lines = text.splitlines()
        self._program = self._ros.start(
            'bash', '-ec', '\n'.join([*self._kept, *lines]), cwd=str(self._folder),
            start_new_session=True)
        self._kept += [line for line in lines if re.match('(cd|source|export) ', line)]
        self._begin = 0
        if not is_endless:
            wait_for(lambda: not self._program.is_running(), self.output, LONGEST_S)
            assert self._program.wait() == 0, self._program.output

    def output(self):
        """Return what was printed since the last step of the reader in any terminal."""
        return self._program.output[self._begin:] if self._program else ''

    def wait_line(self, line):
        """Wait until it was printed since the last step of the reader in any terminal."""
        def is_printed():
            return re.search(pattern(line), self.output())
        wait_for(lambda: is_printed() or not self._program.is_running(),
                 lambda: '{!r} in:\n{}'.format(line, self.output()))
        if not self._program.is_running():
            self._program.wait()        # for the last lines
        assert is_printed(), '{!r} is not in:\n{}'.format(line, self.output())

    def mark(self):
        """What is printed from now on is new."""
        self._begin = len(self._program.output) if self._program else 0

    def interrupt(self):
        """Press Ctrl-C; wait for the end.

        Seldom, Ctrl-C does not end `rostopic pub -r`: the handler of rospy then waits for a lock
        that the interrupted publish holds. The reader presses Ctrl-\\, as the lesson says.
        """
        assert self._program.is_running(), self._program.output
        os.killpg(self._program.pid, signal.SIGINT)
        if self._lines[-1].startswith('rostopic pub -r '):
            with contextlib.suppress(AssertionError):
                wait_for(lambda: not self._program.is_running(), 'its end', ROSPY_END_S)
            if self._program.is_running():
                os.killpg(self._program.pid, signal.SIGQUIT)
        self._program.wait()


def is_endless(step, later):
    """Return whether the reader ends what was typed with Ctrl-C."""
    there = [each.kind for each in later if each.where == step.where and each.kind != 'read']
    return there[:1] == ['interrupt']


def follow(ros, todo, home):
    """Do what a lesson says."""
    ros.env.update(HOME=str(home), LANG='C.UTF-8')
    for name in ('ROS_HOSTNAME', 'SETUPTOOLS_USE_DISTUTILS'):       # ./run sets them
        ros.env.pop(name, None)
    ros.stack.callback(end_all, ros.marker)
    folder = home / 'img_recog'
    folder.mkdir()
    for name in ('config', 'run', 'urdf'):
        (folder / name).symlink_to(os.path.join(ROOT, name))
    terminals = {step.where: Terminal(ros, folder) for step in todo if step.kind == 'type'}
    for number, step in enumerate(todo):
        if step.kind != 'read':
            for terminal in terminals.values():
                terminal.mark()
        if step.kind == 'write':
            pathlib.Path(folder, step.where.replace('~', str(home))).write_text(step.text)
        elif step.kind == 'interrupt':
            terminals[step.where].interrupt()
        elif step.kind == 'type':
            terminals[step.where].type(step.text, is_endless(step, todo[number + 1:]))
        else:
            for line in filter(None, step.text.splitlines()):
                terminals[step.where].wait_line(line)


@pytest.mark.parametrize('name', LESSONS)
def test_all_that_a_lesson_says_happens(ros, tmp_path, name):
    todo = [step for step in steps(read('doc/lessons/' + name)) if not step.needs]
    follow(ros, todo, tmp_path)
    # what it leaves there, other than the files of the reader, is ignored by git
    folder = tmp_path / 'img_recog'
    left = {str(path.relative_to(folder)) for path in folder.rglob('*') if path.is_file()
            and not path.is_symlink()}
    assert shown(tmp_path / 'clone', left - {step.where for step in todo}) == []


@pytest.mark.parametrize('name', [name for name in LESSONS if any(
    step.needs for step in steps(read('doc/lessons/' + name)))])
def test_what_needs_more_packages_happens(ros, tmp_path, name):
    todo = [step for step in steps(read('doc/lessons/' + name)) if step.needs]
    missing = {package for step in todo for package in step.needs.split()} - set(
        rospkg.RosPack().list())
    if missing:
        pytest.skip('these packages of ROS are missing: {}; not run: {}'.format(
            ' '.join(sorted(missing)), [step.text for step in todo if step.kind == 'type']))
    follow(ros, todo, tmp_path)


@pytest.mark.parametrize('name', LESSONS)
def test_the_japanese_lesson_has_the_same_steps(name):
    english, japanese = (read('doc/lessons/' + path) for path in (name, 'ja/' + name))
    assert len(steps(english)) > 10
    assert steps(japanese) == steps(english)
    assert '[日本語](ja/{})'.format(name) in english and '[English](../{})'.format(
        name) in japanese


@pytest.mark.parametrize('command, line', [
    ('echo area 5', 'area 7'), ('echo area 5', 'area ...0'), ('no_such_program', '...')])
def test_a_lesson_that_is_wrong_is_found(ros, tmp_path, command, line):
    page = 'In terminal 1:\n\n```bash\n{}\n```\n\n```text\n{}\n```\n'
    with pytest.raises(AssertionError):
        follow(ros, steps(page.format(command, line)), tmp_path)
