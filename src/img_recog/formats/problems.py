"""What of a world or a model cannot be used: every refusal in its file goes through here."""
import contextlib
import re
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterable, Iterator, List, Tuple

from img_recog.errors import SimulationError
from img_recog.formats import audit
from img_recog.formats.audit import Finding
from img_recog.model import Model

NOT_DOWNLOADED = 'a URL, which is not downloaded'
# what helps when a problem fits a pattern; the scripts of a material are in the folder of a model
_ADVICE = (
    ('model://|^material (?!Gazebo/)', 'set GAZEBO_MODEL_PATH to the folders of the models'),
    ('file://(?!/)', 'set GAZEBO_RESOURCE_PATH to the folders from which their paths start'),
    ('package://', 'build the packages and source their setup.bash'),
    (NOT_DOWNLOADED, 'download the models and include them by model://NAME'))


class Problems:
    """Collects what cannot be used of a file, so that the rest of it is.

    What the file describes is read element by element, each in a `with left_out()`: an element
    that is refused is named here, and the reader goes on with the next one.
    """

    def __init__(self) -> None:
        self._advices: Dict[str, str] = {}      # by problem, in the order in which they came
        self._looks: Dict[str, None] = {}
        self._findings: List[Finding] = []

    @contextlib.contextmanager
    def left_out(self) -> Iterator[None]:
        """Leave out what raises a SimulationError in the `with` block."""
        try:
            yield
        except SimulationError as error:
            self.add(error.problem, error.advice)

    def add(self, problem: str, advice: str = '') -> None:
        """Add what is left out, a name or a sentence, and what helps."""
        self._advices.setdefault(problem, advice)

    def add_look(self, name: str) -> None:
        """Add a material or texture that is not found: without it, the rest is usable."""
        self._looks[name] = None

    def add_missing(self, model: Model) -> None:
        """Add the meshes and looks of a URDF that are not found."""
        for uri in model.missing_meshes:
            self.add('mesh ' + uri)
        for look in model.missing_looks:
            self.add_look(look)

    def audit(self, root: ElementTree.Element) -> None:
        """Add what an <sdf> or a <robot> asks for that is not simulated, and what is not known."""
        self._findings += audit.audit(root)

    def add_finding(self, state: str, what: str, place: str) -> None:
        """Add what a reader finds; arguments as of a Finding."""
        self._findings.append(Finding(state, what, (place,)))

    @property
    def findings(self) -> Tuple[Finding, ...]:
        """What the audits have found, each once."""
        return audit.merged(self._findings)

    @property
    def names(self) -> Tuple[str, ...]:
        """What was left out, each once."""
        return tuple(self._advices)

    @property
    def looks(self) -> Tuple[str, ...]:
        """The materials and textures that are not found, each once."""
        return tuple(self._looks)

    def refuse(self, name: str, otherwise: str) -> None:
        """Raise SimulationError if anything was left out.

        name: of the world or model; otherwise: what the user can do besides mending that.
        """
        if self._advices:
            raise SimulationError('{}: not found, or not supported: {}'.format(
                name, ', '.join(self._advices)), ', or '.join([*self._advice(), otherwise]))

    def warnings(self, name: str) -> List[str]:
        """Return a line about each kind of problem; name: like `refuse`."""
        lines = []
        if self._advices:
            lines.append('{}: loaded without: {}'.format(name, ', '.join(self._advices)))
        if self._looks:
            lines.append('; '.join(['{}: not found, drawn in another color: {}'.format(
                name, ', '.join(self._looks)), *_general_advice(self._looks)]))
        return lines + audit.warnings(name, self.findings)

    def _advice(self) -> List[str]:
        given = [advice for advice in self._advices.values() if advice]
        return list(dict.fromkeys([*given, *_general_advice(self._advices)]))


def _general_advice(problems: Iterable[str]) -> List[str]:
    return [advice for pattern, advice in _ADVICE
            if any(re.search(pattern, problem) for problem in problems)]
