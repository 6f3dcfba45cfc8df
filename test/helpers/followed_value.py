"""Runs a script, and writes which of our files a number passes through.

usage: followed_value.py RESULT NUMBER[,NUMBER ...] SCRIPT [ARGUMENT ...]

A file counts if one of its functions is running when a function of ours is called with one of the
numbers, or returns one: also those that only call the function that has it, up to the loop of the
node, and those that only pass it on. Each number must be one that nothing else has.
"""
import json
import math
import os
import runpy
import sys
import threading

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'src', 'img_recog')
_MAX_DEPTH = 4          # levels of tuples and messages in one another
# functions of a node that call all else: what is above them is the same for every value
_LOOPS = ('spin',)


class Followed:
    """Notes the files."""

    def __init__(self, numbers):
        self._numbers, self._package = numbers, os.path.realpath(PACKAGE) + os.sep
        self.files = set()

    def look(self, frame, event, value):
        """Look at a call or a return; for sys.setprofile."""
        if event not in ('call', 'return') or not self._is_ours(frame):
            return
        found = [value] if event == 'return' else [
            each for name, each in frame.f_locals.items() if name != 'self']
        if not any(map(self._has, found)):
            return
        while frame is not None:
            if self._is_ours(frame):
                self.files.add(os.path.relpath(frame.f_code.co_filename, self._package))
                if frame.f_code.co_name in _LOOPS:
                    return
            frame = frame.f_back

    def _is_ours(self, frame):
        return frame.f_code.co_filename.startswith(self._package)

    def _has(self, value, depth=0):
        if isinstance(value, float):
            return any(math.isclose(value, number, rel_tol=1e-9) for number in self._numbers)
        if depth == _MAX_DEPTH:
            return False
        if isinstance(value, (tuple, list)):
            return len(value) < 10 and any(self._has(each, depth + 1) for each in value)
        slots = getattr(type(value), '_slot_types', None) and value.__slots__
        return bool(slots) and any(self._has(getattr(value, slot), depth + 1) for slot in slots)


def main():
    """Run the script with the rest of the arguments."""
    result, numbers, script = sys.argv[1:4]
    followed = Followed([float(number) for number in numbers.split(',')])
    sys.argv = sys.argv[3:]
    sys.path.insert(0, os.path.dirname(script))
    threading.setprofile(followed.look)
    sys.setprofile(followed.look)
    try:
        runpy.run_path(script, run_name='__main__')
    finally:
        sys.setprofile(None)
        with open(result, 'w') as file:
            json.dump(sorted(followed.files), file)


if __name__ == '__main__':
    main()
