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
    # no traceback of a Ctrl-C while modules load
    signals.handle(signal.SIG_DFL, [signal.SIGINT])
    if one_thread:
        os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')
    gc.disable()        # a tenth of the start of a node: modules that load leave no garbage
    main = importlib.import_module(module).main
    gc.enable()
    sys.exit(main(*arguments))
