"""The summary of the results of all tests."""
import pathlib
import subprocess
import sys

SUMMARY = pathlib.Path(__file__).parents[1] / 'summary.py'
PASSED = '<testsuite><testcase name="one"/><testcase name="two"><skipped/></testcase></testsuite>'
FAILED = '<testsuite><testcase name="one"/><testcase name="bad"><failure/></testcase></testsuite>'


def run(folder, *options):
    result = subprocess.run([sys.executable, str(SUMMARY), str(folder), *options],
                            stdout=subprocess.PIPE, universal_newlines=True, check=False)
    return result.returncode, result.stdout.splitlines()


def test_failures_and_totals(tmp_path):
    for name, text in (('a', PASSED), ('b', FAILED), ('c', FAILED[:30])):
        (tmp_path / (name + '.xml')).write_text(text)
    assert run(tmp_path) == (1, ['FAILED b.xml: bad', 'FAILED c.xml: no complete results',
                                 '2 passed, 2 failed, 1 skipped'])


def test_no_failure(tmp_path):
    assert run(tmp_path) == (1, ['0 passed, 0 failed, 0 skipped'])
    (tmp_path / 'a.xml').write_text(PASSED)
    assert run(tmp_path) == (0, ['1 passed, 0 failed, 1 skipped'])


def test_what_can_run_again_are_tests_with_processes(tmp_path):
    for name, text in (('pytest-system-test_page', FAILED), ('pytest-system-test_run', PASSED),
                       ('pytest-unit-unit', FAILED), ('rosunit-drive', FAILED),
                       ('rostest-test_rostest_demo', FAILED)):
        (tmp_path / (name + '.xml')).write_text(text)
    assert run(tmp_path, '--targets') == (0, ['pytest_system_test_page',
                                              'rostest_test_rostest_demo.test'])
