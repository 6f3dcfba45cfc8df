"""Docstrings of the pure folders show what functions return; pytest runs these examples."""
import ast
import pathlib

from img_recog_helpers.pages import ROOT

PURE = ('camera', 'conversions', 'formats', 'recognition', 'rendering', 'simulation',
        'teleoperation')
KINDS = (ast.FunctionDef, ast.ClassDef)
WANTED = 30


def with_example(path):
    """Return the public functions and classes of a file whose docstrings have an example."""
    return [node.name for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, KINDS)
            and not node.name.startswith('_') and '>>> ' in (ast.get_docstring(node) or '')]


def test_public_functions_have_examples():
    found = [name for folder in PURE
             for path in pathlib.Path(ROOT, 'src', 'img_recog', folder).rglob('*.py')
             for name in with_example(path)]
    assert len(found) >= WANTED, found


def test_both_ways_to_run_the_unit_tests_run_the_examples():
    for path in ('cmake/tests.cmake', 'tools/testing.py'):
        assert '--doctest-modules' in pathlib.Path(ROOT, path).read_text(), path
