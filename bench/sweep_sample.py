"""Print how long closed loops of sweep.py take, without the start of the processes, as JSON.

Arguments: JOBS LOOPS SECONDS: processes, loops, and simulated time of a loop.
"""
import json
import os
import sys
import tempfile
import time

from ros_processes import HERE, cpu_s, descendants

from img_recog.batch import sweep_run
from img_recog.batch.engine import Engine
from img_recog.batch.options import Options
from img_recog.batch.sweep_file import Run, Success
from img_recog.batch.work import Piece
from img_recog.processes.signals import Interrupts

_COLORS = os.path.join(os.path.dirname(HERE), 'config', 'follow.yaml')
_NEVER = Success(0.001)     # a loop ends when its time is up


def _pieces(count: int, seconds: float) -> list:
    return [Piece(str(number), ((), Run(str(number), {}, number, {
        'world': 'color_posts', 'goal': 'blue_post*', 'colors': _COLORS}), _NEVER, seconds))
            for number in range(count)]


def main() -> int:
    """Measure."""
    jobs, loops, seconds = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    with tempfile.TemporaryDirectory() as folder, Engine(Options(jobs), Interrupts()) as engine:
        def run(count: int, seconds: float) -> None:
            with engine.outcomes(sweep_run.run, _pieces(count, seconds),
                                 os.path.join(folder, 'work')) as outcomes:
                for each in outcomes:
                    if each.problem:
                        raise RuntimeError(each.problem)
        run(4 * jobs, 0.5)      # starts the processes, and has each load what it needs
        begin_s, before_s = time.perf_counter(), sum(map(cpu_s, descendants(os.getpid())))
        run(loops, seconds)
        sys.stdout.write(json.dumps({
            'wall_s': time.perf_counter() - begin_s,
            'cpu_s': sum(map(cpu_s, descendants(os.getpid()))) - before_s}) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
