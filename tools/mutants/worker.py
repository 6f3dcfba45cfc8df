"""Runs unit tests in a copy of the tree; each run is a fork that has the libraries loaded.

Started by main.py with the Python that has ROS: worker.py COPY. Reads a request per line of the
standard input and answers with a line, both in JSON:

{"tests": [...], "limits": {test: s}} -> {"code": exit code of pytest, 14 and more after a timeout}
{"record": FILE, "files": [...]} -> {"code": ...}: run all tests of these files, write which test
    runs which line, and how long each takes, to FILE.
"""
import collections
import importlib
import json
import os
import resource
import signal
import sys

import pytest

# what the tests import and the mutants do not change; importing it takes longer than most tests
_LIBRARIES = ('coverage', 'cv2', 'cv_bridge', 'genpy', 'geometry_msgs.msg', 'matplotlib.figure',
              'nav_msgs.msg', 'numpy', 'pybullet', 'rosbag', 'sensor_msgs.msg', 'tf2_msgs.msg',
              'xacro', 'yaml')
_MAX_DATA_BYTES = 8 << 30       # a mutant must not take the memory of the machine


class _Selected:
    """Runs only the given tests, in the given order, each with a time limit in s."""

    def __init__(self, tests, limits):
        self._order = {test: number for number, test in enumerate(tests)}
        self._limits = limits

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        items[:] = sorted((item for item in items if item.nodeid in self._order),
                          key=lambda item: self._order[item.nodeid])

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        # the signal ends the process, even if it hangs outside of Python
        signal.setitimer(signal.ITIMER_REAL, self._limits[item.nodeid])
        yield
        signal.setitimer(signal.ITIMER_REAL, 0)


class _Recorder:
    """Records which test runs which line."""

    def __init__(self, path):
        import coverage
        self._path = path
        self._coverage = coverage.Coverage(data_file=None, config_file=False, source=['src'])
        self._seconds = collections.defaultdict(float)
        self._failed = set()
        self._coverage.start()

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        self._coverage.switch_context(item.nodeid)
        yield

    def pytest_runtest_logreport(self, report):
        self._seconds[report.nodeid] += report.duration
        if report.failed:
            self._failed.add(report.nodeid)

    def pytest_sessionfinish(self):
        self._coverage.stop()
        data = self._coverage.get_data()
        tests = {test: (seconds, {}) for test, seconds in self._seconds.items()
                 if test not in self._failed}
        for file in data.measured_files():
            for line, names in data.contexts_by_lineno(file).items():
                for test in tests.keys() & names:
                    tests[test][1].setdefault(os.path.relpath(file), []).append(line)
        with open(self._path, 'w') as stream:
            json.dump({'tests': tests, 'failed': sorted(self._failed)}, stream)


def _run(request, copy):
    """Run pytest in this process; does not return."""
    os.setsid()
    # nohup and & of a shell ignore them, and tests need them
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    resource.setrlimit(resource.RLIMIT_DATA, (_MAX_DATA_BYTES, _MAX_DATA_BYTES))
    for number, name in ((0, os.devnull), (1, copy + '.log'), (2, copy + '.log')):
        os.dup2(os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC), number)
    arguments = ['-q', '-p', 'no:cacheprovider', '--basetemp', copy + '.tmp', '--doctest-modules']
    if 'record' in request:
        plugin = _Recorder(request['record'])
        arguments += request['files']
    else:
        plugin = _Selected(request['tests'], request['limits'])
        arguments += ['-x'] + sorted({test.split('::')[0] for test in request['tests']})
    code = 70
    try:
        code = pytest.main(arguments, plugins=[plugin])
    finally:
        os._exit(code)


def main() -> None:
    copy = sys.argv[1]
    os.chdir(copy)
    sys.path[:0] = [copy + '/src', copy + '/test']
    for name in _LIBRARIES:
        importlib.import_module(name)
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            _run(json.loads(line), copy)
        status = os.waitpid(child, 0)[1]
        try:
            os.killpg(child, signal.SIGKILL)    # processes that the tests left
        except ProcessLookupError:
            pass
        code = os.WTERMSIG(status) + 100 if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
        print(json.dumps({'code': code}), flush=True)


if __name__ == '__main__':
    main()
