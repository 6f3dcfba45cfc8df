"""The picture of a recorded drive, with a stand-in for plot.py."""
import os
import re

import pytest

from img_recog.errors import UserError
from img_recog.nodes.web import live_tab


@pytest.fixture
def rosrun(tmp_path, monkeypatch):
    """A function that puts a shell script in the place of rosrun."""
    def put(script):
        path = tmp_path / 'rosrun'
        path.write_text('#!/bin/sh\n' + script)
        path.chmod(0o755)
        monkeypatch.setenv('PATH', '{}:{}'.format(tmp_path, os.environ['PATH']))
    return put


@pytest.mark.parametrize('robot, colors, more', [
    ('', '', '$'), ('tb3_1', 'colors: [blue]', ' --robot tb3_1 --colors .*[.]yaml$')])
def test_what_plot_gets(tmp_path, rosrun, robot, colors, more):
    rosrun('echo "$@" >"$3.words"; [ -z "$8" ] || cat "$8" >"$3.colors"')
    path = str(tmp_path / 'in.bag')
    assert live_tab.draw(path, robot, colors) == str(tmp_path / 'in.png')
    assert re.match('img_recog plot.py {} {}{}'.format(path, tmp_path / 'in.png', more),
                    (tmp_path / 'in.bag.words').read_text())
    if colors:
        assert (tmp_path / 'in.bag.colors').read_text() == colors


@pytest.mark.parametrize('script, problem', [
    ('echo "plot.py: error: in.bag has no odometry" >&2; exit 1', '^in.bag has no odometry$'),
    ('exit 3', '^exit code 3$'), ('sleep 60 >&- 2>&-', '^no picture of .*in.bag: .*timed out')])
def test_a_picture_that_is_not_drawn(tmp_path, rosrun, monkeypatch, script, problem):
    monkeypatch.setattr(live_tab, 'TIMEOUT_S', 1.0)
    rosrun(script)
    with pytest.raises(UserError, match=problem):
        live_tab.draw(str(tmp_path / 'in.bag'), '', '')
