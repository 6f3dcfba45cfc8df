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
        return _flush(job.main(painter, begin_s))


def _flush(code: int) -> int:
    """Write out what stands in the buffers; return the exit code, 1 when nobody reads it."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            # Python would try once more at its end, complain, and exit with 120
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            code = code or 1
    return code
