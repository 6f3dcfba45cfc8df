"""What sets of colors make of recordings: areas, commands and the path of a simulated robot.

The functions of pieces are here; `evaluate_job` puts their results together.
"""
import functools
from typing import Dict, Iterator, List, NamedTuple, Sequence, Tuple

import numpy as np

from img_recog.loading import resources
from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command, Commander
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import parts
from img_recog.recordings.frames import SECOND_NS, Frame, Part, Remarks
from img_recog.replay import scenario
from img_recog.replay.chain import (Chain, ColorRecognition, FrameMeasurement, FrameResult,
                                    Recorder)
from img_recog.simulation.simulation_settings import SpawnSettings


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


class Driven(NamedTuple):
    """What one set of colors does in a recording, frame by frame.

    commands: published for each frame; poses: x, y in m and yaw in rad of the simulated robot,
    (frames, 3), without rows if there is none.
    """

    commands: List[List[Command]]
    poses: np.ndarray


class ColorSet(NamedTuple):
    """A file with colors; name: in the output."""

    name: str
    path: str
    settings: RecognitionSettings


class Evaluated(NamedTuple):
    """A recording, and what each set of colors does in it."""

    name: str
    measured: Measured
    driven: List[Driven]


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


def drive(paths: Sequence[str], measured: Measured, number: int, world: str,
          spawn: SpawnSettings) -> Driven:
    """Return the commands for a recording; for the engine.

    paths: of the set of colors, whose number in `measured` is `number`; and of the world, if that
    is a file. world: its name, '' for no robot. spawn: where it starts.
    """
    settings = parameter_file.read(paths[0])
    areas_px = measured.areas_px[number]
    if not world:
        return Driven(_commands(settings, measured.stamps_ns, areas_px), np.empty((0, 3)))
    built = scenario.build(paths[1] if len(paths) > 1 else world, resources.burger(), spawn)
    try:
        recorder = _Recorder()
        chain = Chain(built.simulator, ColorRecognition(settings), False, [recorder])
        stamps_ns = measured.stamps_ns
        period_ns = (stamps_ns[-1] - stamps_ns[0]) // max(1, len(stamps_ns) - 1)
        chain.end(chain.run(_without_images(measured, areas_px)) + period_ns)
    finally:
        built.simulator.close()
    return Driven(recorder.commands, np.array(recorder.poses).reshape(-1, 3))


def _commands(settings: RecognitionSettings, stamps_ns: Sequence[int], areas_px: np.ndarray
              ) -> List[List[Command]]:
    commander = Commander(settings, 0.0)
    return [commander.decide(areas, (stamp_ns - stamps_ns[0]) / SECOND_NS)
            for stamp_ns, areas in zip(stamps_ns, areas_px.tolist())]


def _without_images(measured: Measured, areas_px: np.ndarray) -> Iterator[FrameMeasurement]:
    for number, stamp_ns, areas in zip(measured.numbers, measured.stamps_ns, areas_px.tolist()):
        frame = Frame(number, stamp_ns, None, np.empty((0, 0, 3), np.uint8), 'rgb8')
        yield FrameMeasurement(frame, areas, [None] * len(areas))


class _Recorder(Recorder):
    def __init__(self) -> None:
        self.commands: List[List[Command]] = []
        self.poses: List[Tuple[float, float, float]] = []

    def on_frame(self, result: FrameResult) -> None:
        self.commands.append(list(result.commands))
        position = result.motion.position
        self.poses.append((float(position[0]), float(position[1]), result.motion.yaw))


def score(evaluated: Evaluated, number: int, color: int, settings: RecognitionSettings,
          truth: Truth) -> Score:
    """Return in which frames a color is found.

    number: of the set of colors; color: its number in `settings`, those of the set. Frames that
    `truth` says nothing about do not count.
    """
    name, limit_px = settings.colors[color].name, settings.colors[color].area_limit_px
    known = truth.get(evaluated.name, {})
    pairs = [(bool(area_px > limit_px), known[frame, name]) for frame, area_px in zip(
        evaluated.measured.numbers, evaluated.measured.areas_px[number][:, color])
             if (frame, name) in known]
    return Score(pairs.count((True, True)), pairs.count((True, False)),
                 pairs.count((False, True)))
