"""The list of all that is not done as a file asks, from its first line to the last step.

The lines of the log, the rows of check_robot.py and check_world.py, the refusal of a world that is
not complete and the exit codes of programs are views of this list.
"""
import contextlib
import re
from typing import Callable, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

from img_recog.errors import SimulationError

# kinds of findings: what makes a result partial
LEFT_OUT, NOT_FOUND, NOT_DRAWN = 'left out', 'not found', 'not drawn'
NOT_SIMULATED, NOT_KNOWN = 'not simulated', 'not known'
NOT_USED, NOT_UNIQUE = 'not used', 'not unique'
# the rest does not: a value that is in no file, something that was moved, a whole sentence
ASSUMED, LIFTED, NOTE = 'assumed', 'lifted', 'note'
_PARTIAL = (LEFT_OUT, NOT_FOUND, NOT_DRAWN, NOT_SIMULATED, NOT_KNOWN, NOT_USED, NOT_UNIQUE)
_PHRASES = {LEFT_OUT: 'loaded without', NOT_FOUND: 'not found, drawn in another color',
            LIFTED: 'in the floor at the start, and lifted onto it'}
_MAX_PLACES = 3             # that a line names
NOT_DOWNLOADED = 'a URL, which is not downloaded'
# advice for findings that fit a pattern; the scripts of a material are in the folder of a model
_ADVICE = (
    ('model://|^material (?!Gazebo/)', 'set GAZEBO_MODEL_PATH to the folders of the models'),
    ('file://(?!/)', 'set GAZEBO_RESOURCE_PATH to the folders from which their paths start'),
    ('package://', 'build the packages and source their setup.bash'),
    (NOT_DOWNLOADED, 'download the models and include them by model://NAME'))


class Finding(NamedTuple):
    """Something that is not done as a file asks.

    Attributes:
        kind: One of the constants above.
        what: Element, plugin, file ..., or a whole sentence.
        where: Places in the file that the user wrote, like 'model shelf link top'.
        advice: What the user can do.
        owner: Begins the line: the file of a robot, 'world NAME' or 'model NAME'.
    """

    kind: str
    what: str
    where: Tuple[str, ...] = ()
    advice: str = ''
    owner: str = ''

    def places(self) -> str:
        """Return the first places, and how many more there are."""
        more = len(self.where) - _MAX_PLACES
        return ', '.join(self.where[:_MAX_PLACES]) + ' and {} more'.format(more) * (more > 0)

    def text(self) -> str:
        """Return it for the user.

        >>> Finding('not known', '<modle>', ('world default',)).text()
        '<modle> of world default'
        """
        return '{} of {}'.format(self.what, self.places()) if self.where else self.what


class Report:
    """Findings in the order in which they came.

    Attributes:
        owner: Owner of the findings that are added here.
    """

    def __init__(self, owner: str = ''):
        self.owner, self._whole = owner, self
        self._findings: List[Finding] = []
        self._listener: Optional[Callable[[str], None]] = None
        self._is_partial = False

    def about(self, owner: str) -> 'Report':
        """Return the same list for findings of another owner."""
        report = Report(owner)
        report._whole = self._whole
        return report

    def add(self, kind: str, what: str, *where: str, advice: str = '') -> None:
        """Add a finding; arguments as for Finding."""
        self.extend([Finding(kind, what, where, advice)])

    def assume(self, what: str, line: str) -> None:
        """Add a value that is in no file; line: says so in the log."""
        self.extend([Finding(ASSUMED, what), Finding(NOTE, line)])

    def extend(self, findings: Iterable[Finding]) -> None:
        """Add findings; those without an owner get this one."""
        new = [each if each.owner else each._replace(owner=self.owner) for each in findings]
        whole = self._whole
        whole._is_partial |= any(each.kind in _PARTIAL for each in new)
        if whole._listener is None:
            whole._findings += new
        else:
            for line in lines_of(_merged(new)):
                whole._listener(line)

    def listen(self, listener: Callable[[str], None]) -> None:
        """Pass the lines of all findings from now on to a function, and do not keep them."""
        self._whole._listener = listener

    @contextlib.contextmanager
    def left_out(self) -> Iterator[None]:
        """Leave out what raises a SimulationError in the `with` block: its problem is a finding.

        A reader goes on with the next element of the file.
        """
        try:
            yield
        except SimulationError as error:
            self.add(LEFT_OUT, error.problem, advice=error.advice)

    @property
    def findings(self) -> Tuple[Finding, ...]:
        """All findings; equal ones are one, with all of their places."""
        return _merged(self._whole._findings)

    def of(self, *kinds: str) -> List[str]:
        """Return the text of each finding of some kinds."""
        return list(dict.fromkeys(
            finding.text() for finding in self.findings if finding.kind in kinds))

    @property
    def is_partial(self) -> bool:
        """Whether something that a file asks for is not done."""
        return self._whole._is_partial

    def lines(self) -> List[str]:
        """Return the lines of a log; see `lines_of`."""
        return lines_of(self.findings)

    def refuse(self, otherwise: str) -> None:
        """Raise SimulationError if something of the owner is left out.

        otherwise: what the user can do besides mending that.
        """
        found = [each for each in self.findings
                 if each.kind == LEFT_OUT and each.owner == self.owner]
        if found:
            raise SimulationError('{}: not found, or not supported: {}'.format(
                self.owner, ', '.join(dict.fromkeys(each.what for each in found))),
                ', or '.join([*_advice(found), otherwise]))


def _merged(findings: Iterable[Finding]) -> Tuple[Finding, ...]:
    places: Dict[Finding, Dict[str, None]] = {}
    for finding in findings:
        places.setdefault(finding._replace(where=()), {}).update(dict.fromkeys(finding.where))
    return tuple(key._replace(where=tuple(found)) for key, found in places.items())


def lines_of(findings: Iterable[Finding]) -> List[str]:
    """Return the lines of a log: one for each owner and kind, and one for each sentence."""
    groups: Dict[Tuple[str, ...], List[Finding]] = {}
    for finding in findings:
        if finding.kind != ASSUMED:
            key = finding.owner, finding.kind, finding.what * (finding.kind == NOTE)
            groups.setdefault(key, []).append(finding)
    return ['; '.join([': '.join(filter(None, (
        owner, '' if kind == NOTE else _PHRASES.get(kind, kind),
        ', '.join(dict.fromkeys(each.text() for each in group))))), *_advice(group)])
            for (owner, kind, _), group in groups.items()]


def _advice(findings: List[Finding]) -> List[str]:
    given = [finding.advice for finding in findings if finding.advice]
    return list(dict.fromkeys([*given, *(
        advice for pattern, advice in _ADVICE if any(
            finding.kind in (LEFT_OUT, NOT_FOUND) and re.search(pattern, finding.what)
            for finding in findings))]))
