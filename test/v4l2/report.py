"""Counts checks and prints one line for each."""
import contextlib
import time


class Report:
    """Runs checks, and prints how each of them went."""

    def __init__(self):
        self.passed = self.failed = 0
        self._begin = time.monotonic()

    @contextlib.contextmanager
    def check(self, name, *nodes):
        """Run the body as one check; append what was measured to the list that is yielded.

        nodes: processes whose log is printed when the check fails.
        """
        measured = []
        try:
            yield measured
        except Exception as error:      # the other checks still run
            self.failed += 1
            self._print('FAILED', name, ['{}: {}'.format(type(error).__name__, error)])
            for node in nodes:
                print('    ' + node.output.strip().replace('\n', '\n    '), flush=True)
        else:
            self.passed += 1
            self._print('ok', name, measured)

    def _print(self, verdict, name, measured):
        print('{:5.0f} s {:6} {}{}'.format(
            time.monotonic() - self._begin, verdict, name,
            ': ' + '; '.join(map(str, measured)) if measured else ''), flush=True)

    def summary(self):
        """Return the verdict line."""
        return 'v4l2 checks: {} ok, {} failed'.format(self.passed, self.failed)
