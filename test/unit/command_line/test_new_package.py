"""new_package.py: what it copies, and the names and folders that it refuses.

That the package is built and its tests pass is in test/system/test_new_package.py.
"""
import os
import sys

import pytest

from img_recog.command_line import new_package
from img_recog_helpers.pages import ROOT


@pytest.fixture
def run(monkeypatch, capsys, caplog, handlers_as_before):
    """A function that runs the program; returns the exit code, the output and the log."""
    def run(*arguments):
        monkeypatch.setattr(sys, 'argv', ['new_package.py', *map(str, arguments)])
        return new_package.main(), capsys.readouterr().out, '\n'.join(caplog.messages)
    return run


def files(folder):
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob('*')
            if path.is_file()}


def test_the_template_is_copied_with_another_name(run, tmp_path, monkeypatch):
    template = tmp_path / 'img_recog' / 'templates' / 'my_robot_vision'
    (template / 'scripts' / '__pycache__').mkdir(parents=True)
    (template.parent.parent / 'launch').mkdir()
    for path, text in ((template.parent.parent / 'package.xml', '<package><name>img_recog</name>'
                        '<version>1.0.0</version></package>'),
                       (template.parent.parent / 'launch' / 'demo.launch', '<launch/>'),
                       (template / 'scripts' / '__pycache__' / 'a', ''),
                       (template / 'scripts' / 'my_robot_vision.py', '#!/a\nmy_robot_vision é'),
                       (template / '.hidden', 'My robot, my_robot_vision and my_robot_vision')):
        path.write_text(text, encoding='utf-8')
    (tmp_path / 'src').mkdir()
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path / 'img_recog'))
    made = tmp_path / 'src' / 'follow_2'
    assert run('follow_2', tmp_path / 'src') == (0, 'made the package {}\n'.format(made), '')
    assert files(tmp_path / 'src') == {
        'follow_2/scripts/follow_2.py': '#!/a\nfollow_2 é',
        'follow_2/.hidden': 'My robot, follow_2 and follow_2'}
    assert [(made / name).stat().st_mode & 0o777 for name in ('scripts/follow_2.py', '.hidden')] \
        == [0o755, 0o644]


@pytest.mark.parametrize('name, words', [
    ('Driver', "got the name 'Driver'; a package name has small letters, digits and underscores"),
    ('../driver', "got the name '../driver'"),
    ('rospy', 'there is a package rospy in '), ('sys', 'there is a Python module sys'),
    ('numpy', 'the node would be numpy.py, and there is a Python module numpy'),
    ('gazebo', 'simulator.launch has a node gazebo; choose another name'),
    ('taken', 'taken exists; choose another name or folder'),
    ('dangling', 'dangling exists; choose another name or folder')])
def test_names_that_cannot_be_used(run, tmp_path, name, words):
    (tmp_path / 'taken').mkdir()
    (tmp_path / 'dangling').symlink_to('none')
    code, output, line = run(name, tmp_path)
    assert (code, output) == (1, '')
    assert words in line and '\n' not in line
    assert sorted(os.listdir(str(tmp_path))) == ['dangling', 'taken']


@pytest.mark.parametrize('folder, words', [
    ('none', 'there is no folder {}; make it first'),
    (ROOT, 'is in the package {0}, where ROS finds no other; give'),
    (os.path.join(ROOT, 'doc'), '{} is in the package ' + ROOT),
    ('/proc', 'cannot make {}/post_driver: ')])
def test_folders_that_cannot_be_used(run, tmp_path, monkeypatch, folder, words):
    monkeypatch.chdir(tmp_path)
    code, _, line = run('post_driver', folder)
    assert code == 1 and words.format(os.path.abspath(folder)) in line
    assert '\n' not in line
