"""The lessons: every command and every file in them, and what is printed, as they say."""
import glob
import os
import pathlib
import re
import signal

import pytest
import rospkg

from img_recog_helpers.ignored import shown
from img_recog_helpers.lessons import pattern, steps
from img_recog_helpers.pages import ROOT, read
from img_recog_helpers.process_table import end_all
from img_recog_helpers.waiting import wait_for

LESSONS = sorted(os.path.basename(path)
                 for path in glob.glob(os.path.join(ROOT, 'doc', 'lessons', '*.md')))
LONGEST_S = 400.0       # of a command, on an idle machine


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
        """Press Ctrl-C; wait for the end."""
        assert self._program.is_running(), self._program.output
        os.killpg(self._program.pid, signal.SIGINT)
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


def test_a_lesson_that_is_wrong_is_found(ros, tmp_path):
    page = 'In terminal 1:\n\n```bash\necho area 5\n```\n\n```text\n{}\n```\n'
    follow(ros, steps(page.format('area 7')), tmp_path)
    assert not re.search(pattern('area 0'), 'area 5') and re.search(pattern('x: 0.0'), 'x: 0.0')
    assert not re.search(pattern('-1.5 m'), '1.5 m') and not re.search(pattern('a=3'), 'a=0')
    (tmp_path / 'other').mkdir()
    with pytest.raises(AssertionError):
        follow(ros, steps(page.replace('echo', 'no_such_program').format('area 7')),
               tmp_path / 'other')
