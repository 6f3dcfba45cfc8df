"""The start of the programs in scripts/."""
import gc
import importlib
import signal
import sys
from typing import Any

from img_recog.processes import signals


def start(module: str, *arguments: Any, function: str = 'main') -> None:
    """Import a module, and end with the exit code of its function."""
    # no traceback of a Ctrl-C while modules load
    signals.handle(signal.SIG_DFL, [signal.SIGINT])
    gc.disable()        # a tenth of the start of a node: modules that load leave no garbage
    main = getattr(importlib.import_module(module), function)
    gc.enable()
    sys.exit(main(*arguments))
