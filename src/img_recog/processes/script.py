"""The start of the programs in scripts/."""
import gc
import importlib
import os
import signal
import sys
from typing import Any

from img_recog.processes import signals


def start(module: str, *arguments: Any, one_thread: bool = False) -> None:
    """Import a module, and end with the exit code of its `main`.

    one_thread: for those that multiply small matrices, often in as many processes as cores: the
    threads of numpy would not help them.
    """
    _open_missing_streams()
    # no traceback of a Ctrl-C while modules load
    signals.handle(signal.SIG_DFL, [signal.SIGINT])
    if one_thread:
        os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    gc.disable()        # a tenth of the start of a node: modules that load leave no garbage
    main = importlib.import_module(module).main
    gc.enable()
    sys.exit(main(*arguments))


def _open_missing_streams() -> None:
    """Open the standard streams that the shell has closed (`>&-`).

    Otherwise, a file that is opened later gets the number, and what is printed is written to it.
    A program that writes to stdout fails as on a full disk. What it writes to stderr is lost.
    """
    for number, name, flags in ((0, 'stdin', os.O_RDONLY), (1, 'stdout', os.O_RDONLY),
                                (2, 'stderr', os.O_WRONLY)):
        if getattr(sys, name) is None:
            os.dup2(os.open(os.devnull, flags), number)
            stream = open(number, 'w' if number else 'r', closefd=False)
            setattr(sys, name, stream)
            setattr(sys, '__{}__'.format(name), stream)
