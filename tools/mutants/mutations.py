"""The mutations of a Python file: those of cosmic-ray, those of operators.py, less the filters.

Not mutated are:
- type annotations, TypeVar(...), and `if TYPE_CHECKING` with what is under it
- docstrings, string literals of two words or more or like ', ', and those of `metavar`: these are
  texts for people
- `==` to `is` and the other way round: for small numbers and interned strings nothing changes
- the decorators lru_cache and abstractmethod: a cache changes only the speed, and an abstract
  method only what is said of a class that lacks it
- the -1 of reshape(): NumPy takes any negative number for the length that is left
"""
import ast
import itertools
from collections import defaultdict
from typing import Dict, Iterator, List, NamedTuple, Tuple

import parso
from cosmic_ray.ast import Visitor, ast_nodes
from cosmic_ray.operators import (binary_operator_replacement, boolean_replacer, break_continue,
                                  comparison_operator_replacement, exception_replacer,
                                  number_replacer, remove_decorator, unary_operator_replacement,
                                  zero_iteration_for_loop)

from operators import OPERATORS

_IDENTITY = ('Is', 'IsNot')
_DECORATORS = ('lru_cache', 'abstractmethod')


def _keeps_identity(operator) -> bool:
    source, target = operator.__name__.split('_')[-2:]
    return (source in _IDENTITY) == (target in _IDENTITY)


_ALL = tuple(itertools.chain(
    binary_operator_replacement.operators(),
    filter(_keeps_identity, comparison_operator_replacement.operators()),
    (operator for operator in unary_operator_replacement.operators()
     if not operator.__name__.endswith('_Not')),     # -a to not a: no syntax in most places
    (boolean_replacer.AddNot, boolean_replacer.ReplaceTrueWithFalse,
     boolean_replacer.ReplaceFalseWithTrue, boolean_replacer.ReplaceAndWithOr,
     boolean_replacer.ReplaceOrWithAnd, break_continue.ReplaceBreakWithContinue,
     break_continue.ReplaceContinueWithBreak, exception_replacer.ExceptionReplacer,
     number_replacer.NumberReplacer, remove_decorator.RemoveDecorator,
     zero_iteration_for_loop.ZeroIterationForLoop),
    OPERATORS))


class Place(NamedTuple):
    """A part of a file that can be mutated, in one or several ways.

    line: from 1; end_line: last line of the part; in_function: whether it is run by calls, not by
    the import of the file; variants: operator and index of its match in the file, for `mutated`.
    """

    file: str
    line: int
    end_line: int
    in_function: bool
    variants: Tuple[Tuple[type, int], ...]


class Mutant(NamedTuple):
    """A file with one mutation. before, after: the changed lines, without indentation."""

    place: Place
    source: str
    before: str
    after: str


def places(file: str, source: str) -> List[Place]:
    """Return all places in the source of a file, in their order."""
    counts: Dict[type, int] = defaultdict(int)
    found = defaultdict(list)
    functions = {}
    for node in ast_nodes(parso.parse(source)):
        ignored = None
        for operator in _ALL:
            for start, end in operator().mutation_positions(node):
                if ignored is None:
                    ignored = _is_ignored(node)
                if not ignored:
                    key = (start, end, operator.__module__, node.type)
                    found[key].append((operator, counts[operator]))
                    functions[key] = _is_in_function(node)
                counts[operator] += 1
    return [Place(file, key[0][0], key[1][0], functions[key], tuple(variants))
            for key, variants in sorted(found.items())]


def mutate(place: Place, variant: int, source: str) -> Mutant:
    """Return a mutant of a source. variant: index into `place.variants`."""
    operator, occurrence = place.variants[variant]
    visitor = _Mutation(operator(), occurrence)
    mutated = visitor.walk(parso.parse(source)).get_code()
    ast.parse(mutated)
    before, after = _difference(source.splitlines(), mutated.splitlines())
    return Mutant(place, mutated, before, after)


class _Mutation(Visitor):
    """Mutates the node of one occurrence."""

    def __init__(self, operator, occurrence: int):
        self._operator = operator
        self._left = occurrence

    def visit(self, node):
        for index, _ in enumerate(self._operator.mutation_positions(node)):
            self._left -= 1
            if self._left == -1:
                return self._operator.mutate(node, index)
        return node


def _difference(old: List[str], new: List[str]) -> Tuple[str, str]:
    """Return the lines that differ, joined, of two lists that differ in one place."""
    while old and new and old[0] == new[0]:
        old, new = old[1:], new[1:]
    while old and new and old[-1] == new[-1]:
        old, new = old[:-1], new[:-1]
    before, after = (' '.join(line.strip() for line in lines) for lines in (old, new))
    return before, after


def _ancestors(node) -> Iterator[Tuple]:
    """Yield each ancestor with its child on the way to the node."""
    while node.parent is not None:
        yield node.parent, node
        node = node.parent


def _is_in_function(node) -> bool:
    """Return whether a node is in the body of a function, not in its head or decorators."""
    return any(parent.type in ('funcdef', 'lambdef') and child is parent.children[-1]
               for parent, child in _ancestors(node))


def _is_ignored(node) -> bool:
    if (node.type == 'string' and _is_text(node)) or _is_length_left(node) or _is_for_types(node):
        return True
    if any(each.type == 'decorator' and any(name in each.get_code() for name in _DECORATORS)
           for each in (node, *(parent for parent, _ in _ancestors(node)))):
        return True
    for parent, child in _ancestors(node):
        if parent.type == 'annassign' and child is parent.children[1]:
            return True
        if parent.type == 'tfpdef' and child is not parent.children[0]:
            return True
        if parent.type == 'argument' and parent.children[0].get_code().strip() == 'metavar':
            return True
        if parent.type == 'funcdef' and parent.annotation is child:
            return True
        if _is_for_types(parent):
            return True
        if parent.type == 'expr_stmt' and parent.children[-1].get_code().lstrip().startswith(
                'TypeVar('):
            return True
    return False


def _is_for_types(node) -> bool:
    return node.type == 'if_stmt' and node.children[1].get_code().strip() == 'TYPE_CHECKING'


def _is_length_left(node) -> bool:
    """Return whether a node is the -1 of reshape(), or the 1 in it."""
    number = node if node.type == 'factor' else node.parent
    call = number.search_ancestor('trailer') if number and number.type == 'factor' else None
    return (call is not None and number.get_code().strip() == '-1'
            and call.get_previous_sibling().get_code() == '.reshape')


def _is_text(node) -> bool:
    """Return whether a string literal is a docstring, or has two words, or is like ', '."""
    whole = node.parent if node.parent.type == 'strings' else node
    parts = whole.children if whole.type == 'strings' else [whole]
    value = ''.join(str(ast.literal_eval(part.value)) for part in parts)
    is_separator = value != value.strip() and not any(map(str.isalnum, value))
    return len(value.split()) > 1 or is_separator or whole.parent.type == 'simple_stmt'
