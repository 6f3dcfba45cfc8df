"""The lessons: every command and every file in them, and what is printed, as they say."""
import glob
import os
import pathlib
import re
import signal

import pytest

from img_recog_testing.lessons import pattern, steps
from img_recog_testing.pages import ROOT, read
from img_recog_testing.process_table import end_all
from img_recog_testing.waiting import wait_for

LESSONS = sorted(os.path.basename(path)
                 for path in glob.glob(os.path.join(ROOT, 'doc', 'lessons', '*.md')))


class Terminal:
    """A shell of the reader; where it is and what it has sourced stays from block to block."""

    def __init__(self, ros, folder):
        self._ros, self._folder, self._kept = ros, folder, []
        self._program, self._begin = None, 0

    def type(self, text, is_endless):
        """Run the lines; wait for their end, unless the reader presses Ctrl-C later."""
        assert self._program is None or not self._program.is_running(), 'Ctrl-C is missing'
        # the environment of the test is already the one of this shell
        lines = [re.sub(r'^\./run shell$', './run shell true', line)
                 for line in text.splitlines()]
        self._program = self._ros.start(
            'bash', '-ec', '\n'.join([*self._kept, *lines]), cwd=str(self._folder),
            start_new_session=True)
        self._kept += [line for line in lines if re.match('(cd|source|export) ', line)]
        self._begin = 0
        if not is_endless:
            assert self._program.wait() == 0, self._program.output

    def output(self):
        """Return what was printed since the last step of the reader in any terminal."""
        return self._program.output[self._begin:] if self._program else ''

    def mark(self):
        """What is printed from now on is new."""
        self._begin = len(self._program.output) if self._program else 0

    def interrupt(self):
        """Press Ctrl-C; wait for the end."""
        assert self._program.is_running(), self._program.output
        os.killpg(self._program.pid, signal.SIGINT)
        self._program.wait()


def is_endless(step, later):
    """Return whether the reader ends what was typed with Ctrl-C."""
    there = [each.kind for each in later if each.where == step.where and each.kind != 'read']
    return there[:1] == ['interrupt']


def follow(ros, page, home):
    """Do what a lesson says."""
    folder = home / 'img_recog'
    folder.mkdir()
    (folder / 'run').symlink_to(os.path.join(ROOT, 'run'))
    todo = steps(page)
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
                wait_for(lambda: re.search(pattern(line), terminals[step.where].output()),
                         lambda: '{!r} in:\n{}'.format(line, terminals[step.where].output()))


@pytest.mark.parametrize('name', LESSONS)
def test_all_that_a_lesson_says_happens(ros, tmp_path, name):
    ros.env.update(HOME=str(tmp_path), LANG='C.UTF-8')
    del ros.env['ROS_HOSTNAME']         # ./run sets it
    ros.stack.callback(end_all, ros.marker)
    follow(ros, read('doc/lessons/' + name), tmp_path)


@pytest.mark.parametrize('name', LESSONS)
def test_the_japanese_lesson_has_the_same_steps(name):
    english, japanese = (read('doc/lessons/' + path) for path in (name, 'ja/' + name))
    assert len(steps(english)) > 10
    assert steps(japanese) == steps(english)
    assert '[日本語](ja/{})'.format(name) in english and '[English](../{})'.format(
        name) in japanese


def test_a_lesson_that_is_wrong_is_found(ros, tmp_path):
    page = 'In terminal 1:\n\n```bash\necho area 5\n```\n\n```text\n{}\n```\n'
    follow(ros, page.format('area 7'), tmp_path)
    assert not re.search(pattern('area 0'), 'area 5') and re.search(pattern('x: 0.0'), 'x: 0.0')
    assert not re.search(pattern('-1.5 m'), '1.5 m') and not re.search(pattern('a=3'), 'a=0')
    (tmp_path / 'other').mkdir()
    with pytest.raises(AssertionError):
        follow(ros, page.replace('echo', 'no_such_program').format('area 7'), tmp_path / 'other')
