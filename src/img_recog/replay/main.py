"""The program replay: a video or a bag through recognition and simulation, without a master.

Runs as fast as possible and writes the result as a bag, a table and a picture. The same input
always gives the same files, byte for byte.
"""
import gc
import os
import sys
import time

from img_recog.replay.painter import Painter


def main() -> int:
    """Run the program; return its exit code."""
    begin_s = time.perf_counter()
    # the matrices are too small for the threads of numpy to help
    os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    with Painter() as painter:
        # meanwhile the painter loads its own modules; imported modules never become garbage
        gc.disable()
        from img_recog.replay import job
        gc.freeze()
        gc.enable()
        return job.main(painter, begin_s)


def leave(code: int) -> None:
    """End the process with this exit code, when all files are closed and all children gone.

    To take the interpreter down, with all modules, takes a fifth of a second.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:         # nobody reads it
            code = code or 1
    os._exit(code)
