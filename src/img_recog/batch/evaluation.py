"""What sets of colors make of recordings: areas and commands."""
import functools
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command, Commander
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import parts
from img_recog.recordings.frames import SECOND_NS, Part, Remarks

# whether a color is in view: by recording; by number of the frame, and color
Truth = Dict[str, Dict[Tuple[int, str], bool]]


class Measured(NamedTuple):
    """What was measured in frames, in their order.

    numbers, stamps_ns: of the frames; areas_px: of each set of colors, (frames, colors);
    remarks: on what could not be used.
    """

    numbers: List[int]
    stamps_ns: List[int]
    areas_px: List[np.ndarray]
    remarks: Remarks = Remarks()

    def joined(self, others: Sequence['Measured']) -> 'Measured':
        """Return these frames and those of others."""
        every = [self, *others]
        return Measured(sum((part.numbers for part in every), []),
                        sum((part.stamps_ns for part in every), []),
                        [np.concatenate(areas) for areas in zip(*(
                            part.areas_px for part in every))],
                        functools.reduce(Remarks.plus, (part.remarks for part in every)))


class ColorSet(NamedTuple):
    """A file with colors; name: in the output."""

    name: str
    path: str
    settings: RecognitionSettings


class Evaluated(NamedTuple):
    """A recording, and what each set of colors does in it.

    times_s: of the frames, from the first one; commands: of each set, those published for each
    frame.
    """

    name: str
    measured: Measured
    times_s: List[float]
    commands: List[List[List[Command]]]


def measure(paths: Sequence[str], part: Part, max_pixels: int) -> Measured:
    """Return the areas in a part of a recording; for the engine.

    paths: of the recording and of the sets of colors. Each frame is decoded once.
    """
    settings = [parameter_file.read(path) for path in paths[1:]]
    extractors = [ColorExtractor(each) for each in settings]
    found = Measured([], [], [])
    areas_px: List[List[List[int]]] = [[] for _ in extractors]
    frames = parts.read(paths[0], part, max_pixels)
    for frame in frames.read():
        found.numbers.append(frame.number)
        found.stamps_ns.append(frame.stamp_ns)
        for areas, extractor in zip(areas_px, extractors):
            areas.append(extractor.measure(frame.image, frame.encoding))
    return found._replace(remarks=frames.remarks, areas_px=[
        np.array(areas, np.int32).reshape(len(areas), len(each.colors))
        for areas, each in zip(areas_px, settings)])


def evaluated(name: str, measured: Measured, sets: Sequence[ColorSet]) -> Evaluated:
    """Return what sets of colors do in a recording; measured: by these sets."""
    times_s = [(stamp_ns - measured.stamps_ns[0]) / SECOND_NS for stamp_ns in measured.stamps_ns]
    commands = []
    for colors, areas_px in zip(sets, measured.areas_px):
        commander = Commander(colors.settings, 0.0)
        commands.append(list(map(commander.decide, areas_px.tolist(), times_s)))
    return Evaluated(name, measured, times_s, commands)


def score(found: Evaluated, number: int, color: int, settings: RecognitionSettings,
          truth: Truth) -> Score:
    """Return in which frames a color is found.

    number: of the set of colors; color: its number in `settings`, those of the set. Frames that
    `truth` says nothing about do not count.
    """
    name, limit_px = settings.colors[color].name, settings.colors[color].area_limit_px
    known = truth.get(found.name, {})
    pairs = [(bool(area_px > limit_px), known[frame, name]) for frame, area_px in zip(
        found.measured.numbers, found.measured.areas_px[number][:, color])
             if (frame, name) in known]
    return Score(pairs.count((True, True)), pairs.count((True, False)),
                 pairs.count((False, True)))
