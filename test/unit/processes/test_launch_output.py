"""What is found in the output of roslaunch: which node has ended, and why."""
import glob
import xml.etree.ElementTree as ElementTree

import pytest

from img_recog.processes.launch_output import PARTS, Death, LaunchOutput, describe, last_error
from img_recog_helpers.pages import ROOT

LOG = ('[rosout][INFO] 2026-01-31 10:00:00,000: it begins\n'
       '[rosout][ERROR] 2026-01-31 10:00:01,000: no camera\n'
       '[rosout][{}] 2026-01-31 10:00:02,000: {}\nits next line\n')
DIED = 'process has died [pid 7, exit code {}, cmd /opt/node __name:=node __log:={{}}].'
REQUIRED = '====REQUIRED process [gazebo-2] has died!'
RESPAWN = '[respawn] node: '
RAISED = 'img_recog.errors.UserError: it failed'


@pytest.mark.parametrize('lines, deaths', [
    (['[node-1] ' + DIED.format(1)], [('node', False, 'no disk')]),
    (['\x1b[31m[my_node-12] ' + DIED.format(1) + '\x1b[0m \r\n'], [('my_node', False, 'no disk')]),
    (['[node-1] ' + DIED.format(2).replace('__log', '_')], [('node', False, 'exit code 2')]),
    (['[node-1] ' + DIED.format(0)], [('node', False, 'no disk')]),
    ([RAISED, '[node-1] ' + DIED.format(1)], [('node', False, 'no disk')]),
    # the reason of one node is not that of the next
    ([RAISED, *['[node-1] ' + DIED.format(1).replace('__log', '_')] * 2],
     [('node', False, RAISED), ('node', False, 'exit code 1')]),
    ([RAISED, '[node-1] ' + DIED.format(-11), '[node-1] ' + DIED.format(-99)],
     [('node', False, 'killed by SIGSEGV'), ('node', False, 'killed by signal 99')]),
    ([DIED.format(1), 'process has finished cleanly', '[a-1] process has finished cleanly'], []),
    ([REQUIRED, DIED.format(3).replace('__log', '_'), 'process has finished cleanly'],
     [('gazebo', True, 'exit code 3')]),
    ([REQUIRED, 'process has finished cleanly'], [('gazebo', True, 'exit code 0')]),
    (['ERROR: cannot launch node of type [pkg/none.py]: not there'],
     [('none.py', False, 'cannot launch node of type [pkg/none.py]: not there')]),
    (['[node-1] restarting process'], [('node', False, 'its process died', False)]),
    ([RESPAWN + 'killed by SIGKILL, started again in 1 s'],
     [('node', False, 'killed by SIGKILL', False)]),
    ([RESPAWN + 'ended and is not started again: no camera'], [('node', False, 'no camera')]),
    ([RESPAWN + 'ended and is not started again: it has finished',
      RESPAWN + 'ended and is not started again: another node has taken its name'], []),
    ([RESPAWN + 'ended, and the demo with it: it has finished'],
     [('node', True, 'it has finished')]),
    ([RAISED, *[RESPAWN + 'ended, and the demo with it: exit code 1'] * 2],
     [('node', True, RAISED), ('node', True, 'exit code 1')]),
    ([RAISED, RESPAWN + 'unexpected exception, started again',
      RESPAWN + 'ended, and the demo with it: exit code 1'],
     [('node', False, 'unexpected exception', False), ('node', True, 'exit code 1')]),
    ([RAISED, RESPAWN + 'ended, and the demo with it: no camera'], [('node', True, 'no camera')])])
@pytest.mark.parametrize('log', [LOG.format('CRITICAL', 'no disk'),
                                 LOG + '[FATAL] [1600000000.1]: no disk\nthe end\n'])
def test_deaths(tmp_path, lines, deaths, log):
    path = tmp_path / 'node.log'
    path.write_bytes(b'\xff\n' + log.encode())
    output = LaunchOutput()
    assert list(filter(None, (output.read(line.format(path)) for line in lines))) == [
        Death(*[*death, True][:4]) for death in deaths]         # most are over


def test_the_log_of_a_node_that_has_logged_no_error_or_does_not_exist(tmp_path):
    (tmp_path / 'a').write_text('[rosout][INFO] 2026-01-31 10:00:00,000: it begins\n')
    for name in ('a', 'none'):
        death = LaunchOutput().read('[node-1] ' + DIED.format(1).format(tmp_path / name))
        assert death.reason == 'exit code 1'
        assert last_error(str(tmp_path / name)) == ''


def test_a_process_that_is_started():
    output = LaunchOutput()
    for line, is_launching in (('started roslaunch', False), ('process[a-1]: started', True),
                               ('something else', True)):
        output.read(line)
        assert output.launching == is_launching


def test_each_node_of_the_demo_has_a_name_for_users():
    nodes = [node for path in glob.glob(ROOT + '/launch/*.launch')
             for node in ElementTree.parse(path).iter('node')]
    windows = {'rviz', 'rqt_graph', 'rqt_reconfigure'}      # whose ends are no news
    assert {*PARTS, *windows} == {'master', *(node.get('name') for node in nodes)}
    assert describe(Death('web', False, 'no port.')) == 'the page (web) has ended: no port'
    assert describe(Death('lab/web', False, 'no port')) == 'the page (lab/web) has ended: no port'
    assert describe(Death('mine', False, 'killed')) == 'a node (mine) has ended: killed'
