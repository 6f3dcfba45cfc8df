"""Mutation operators that cosmic-ray does not have, for tools/mutants/mutations.py."""
import ast

import parso
from cosmic_ray.operators.operator import Operator


class _OneMutation(Operator):
    """An operator that has one mutation for each node that it accepts."""

    def mutation_positions(self, node):
        if self.accepts(node):
            yield node.start_pos, node.end_pos

    @classmethod
    def examples(cls):
        return ()


class ReplaceString(_OneMutation):
    """Put an X before the text of a string literal."""

    def accepts(self, node):
        return node.type == 'string'

    def mutate(self, node, index):
        value = ast.literal_eval(node.value)
        node.value = repr((b'X' if isinstance(value, bytes) else 'X') + value)
        return node


class ReturnNone(_OneMutation):
    """Return None in place of a value.

    Not of one that is false as well: mypy refuses that, and for most callers nothing changes.
    """

    def accepts(self, node):
        return node.type == 'return_stmt' and node.children[1].get_code().strip() not in (
            'None', 'False', "''", '0', '0.0', '()', '[]', '{}')

    def mutate(self, node, index):
        node.children[1] = parso.parse(' None')
        return node


class RemoveStatement(_OneMutation):
    """Replace a call, a raise, or an assignment that can be missed by `pass`.

    The first assignment to a local name stays: without it, the next use of the name fails.
    """

    def accepts(self, node):
        if node.parent is None or node.parent.type != 'simple_stmt':
            return False
        if node.type != 'expr_stmt':
            return node.type in ('atom_expr', 'raise_stmt', 'del_stmt', 'yield_expr')
        target = node.children[0]
        if target.type != 'name':
            return target.type in ('atom_expr', 'power')
        function = node.search_ancestor('funcdef')
        if function is None:
            return False
        names = node.get_root_node().get_used_names()[target.value]
        return any(name.is_definition() and name.start_pos < target.start_pos and
                   function.start_pos < name.start_pos for name in names)

    def mutate(self, node, index):
        return parso.python.tree.Keyword('pass', node.start_pos, node.get_first_leaf().prefix)


class InvertIn(Operator):
    """Replace `in` by `not in` and the other way round."""

    def mutation_positions(self, node):
        for child in self._operators(node):
            yield child.start_pos, child.end_pos

    @staticmethod
    def _operators(node):
        if node.type != 'comparison':
            return []
        return [child for child in node.children[1::2]
                if child.get_code().split() in (['in'], ['not', 'in'])]

    def mutate(self, node, index):
        child = self._operators(node)[index]
        other = ' in' if child.get_code().split() == ['not', 'in'] else ' not in'
        node.children[node.children.index(child)] = parso.parse(other)
        return node

    @classmethod
    def examples(cls):
        return ()


OPERATORS = (ReplaceString, ReturnNone, RemoveStatement, InvertIn)
