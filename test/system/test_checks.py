"""check_robot.py, check_world.py and simulate.py as a user runs them, without a master."""
import pytest

from img_recog_helpers.robots import burger


@pytest.fixture
def run(ros, tmp_path):
    """A function that runs a program in a folder; it returns the exit code and the lines."""
    def start(*command):
        process = ros.start_node(*command, cwd=str(tmp_path))
        code = process.wait()
        return code, [line for line in process.output.splitlines()
                      if line and not line.startswith('pybullet build time')]
    return start


@pytest.mark.parametrize('program', ['check_robot.py', 'check_world.py', 'simulate.py'])
def test_wrong_usage_and_no_file(run, program):
    code, lines = run(program)
    assert code == 2 and lines[0].startswith('usage: ' + program), lines
    code, (line,) = run(program, 'none.urdf')
    assert code == 1 and line.startswith(program + ': error: ') and 'none.urdf' in line


def test_what_is_not_done_is_said_by_the_exit_code(run, tmp_path):
    (tmp_path / 'my.urdf').write_text(burger(''))
    code, lines = run('check_robot.py', 'my.urdf')
    assert code == 2 and lines[-1].startswith(
        'warning: my.urdf: it does not drive, as it has no drive'), lines
