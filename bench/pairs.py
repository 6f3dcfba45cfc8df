"""Measures several ways to do the same in turns, and prints their medians side by side."""
from statistics import median
from typing import Callable, Dict, List, NamedTuple, Sequence

from img_recog.command_line.results import text_table

Samples = Dict[str, List[dict]]     # of each way: the numbers of each turn, by their names


class Column(NamedTuple):
    """A number in the table: its name, and its format.

    has_ratio: whether the ratio of the first way to this one follows in brackets. It is the median
    of those within the turns: if the machine is slow for a while, it is slow for all ways.
    """

    title: str
    name: str
    form: str = '{:.2f}'
    has_ratio: bool = False


class Benchmark(NamedTuple):
    """What is compared.

    groups: functions that measure the ways of a group in turns, by the titles of the groups. They
    are called `rounds` times.
    """

    title: str
    groups: Dict[str, Callable[[], Samples]]
    columns: Sequence[Column]
    rounds: int = 3


def each(**ways: Callable[[], dict]) -> Callable[[], Samples]:
    """Return a group of ways that are measured one after the other; _ in a name is a space."""
    return lambda: {name.replace('_', ' '): [way()] for name, way in ways.items()}


def measure(benchmark: Benchmark, done: Callable[[], None]) -> List[dict]:
    """Return a row for each way of each group; done: called after each group of each round."""
    found: Dict[str, Samples] = {group: {} for group in benchmark.groups}
    for _ in range(benchmark.rounds):
        for group, run in benchmark.groups.items():
            for way, turns in run().items():
                found[group].setdefault(way, []).extend(turns)
            done()
    return [_row(benchmark, ', '.join(filter(None, (group, way))), turns,
                 next(iter(ways.values())))
            for group, ways in found.items() for way, turns in ways.items()]


def _row(benchmark: Benchmark, title: str, turns: List[dict], first: List[dict]) -> dict:
    row: dict = {'': title}
    for column in benchmark.columns:
        name = column.name
        if all(name in turn for turn in turns) and turns:
            row[name] = median(turn[name] for turn in turns)
            if column.has_ratio:
                row[name + '_ratio'] = median(
                    mine[name] / turn[name] for mine, turn in zip(first, turns))
    return row


def table(benchmark: Benchmark, rows: List[dict]) -> str:
    """Return the rows as a table; what a way does not have is an empty cell."""
    lines = [[benchmark.title, *(column.title for column in benchmark.columns)]]
    lines += [[row[''], *(_cell(column, row) for column in benchmark.columns)] for row in rows]
    return '\n'.join(text_table(lines))


def _cell(column: Column, row: dict) -> str:
    if column.name not in row:
        return ''
    ratio = ' ({:.2f})'.format(row[column.name + '_ratio']) if column.has_ratio else ''
    return column.form.format(row[column.name]) + ratio
