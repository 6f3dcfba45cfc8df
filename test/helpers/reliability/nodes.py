"""Single nodes with a master of their own, for programs that treat them badly."""
import os
import tempfile
from typing import List

from img_recog_helpers import process_table
from img_recog_helpers.processes import Process, Ros
from img_recog_helpers import wire
from img_recog_helpers.simulator_tools import burger
from img_recog_helpers.waiting import DEADLINE_S, wait_for


class Contained(Ros):
    """Programs with a separate folder, of which nothing is left; use it in a with statement.

    folder: where programs may write.
    """

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix='img_recog_test_')
        super().__init__(self._folder.name)
        self.folder = self._folder.name
        self.env['TMPDIR'] = os.path.join(self.folder, 'tmp')
        os.mkdir(self.env['TMPDIR'])

    def temporary_files(self) -> List[str]:
        return sorted(os.listdir(self.env['TMPDIR']))

    def close(self) -> None:
        """Kill what is left."""
        process_table.end_all(self.marker)
        super().close()
        self._folder.cleanup()


class Nodes(Contained):
    """A running master, and nodes that are started on it."""

    def __init__(self) -> None:
        super().__init__()
        # without the marker: it is not under test
        self.start_core(env={**self.env, self.marker.partition('=')[0]: ''})

    def start_node(self, script: str, *arguments: str) -> Process:
        """Start a script of this package; a simulator gets the robot's description."""
        if script == 'pybullet_sim.py':
            self.set_parameters('/robot_description', burger())
        return super().start_node(script, *arguments)

    def forget(self, process: Process) -> None:
        """Drop a process that has ended, and its output."""
        self.processes.remove(process)

    def subscribe(self, node: str, topic: str, data_class: type) -> wire.Subscription:
        """Subscribe to a topic once the node publishes it."""
        def subscription():
            try:
                return wire.Subscription(self.master_uri, node, topic, data_class, DEADLINE_S)
            except wire.ERRORS:
                return None
        return wait_for(subscription, lambda: '{} of {}\n{}'.format(
            topic, node, self.output()[-3000:]))

    def output(self) -> str:
        """Return what the programs have printed, one after the other."""
        return ''.join(process.output for process in self.processes)
