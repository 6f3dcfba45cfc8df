"""What fit_colors.py does with a part of a recording: counts its colors, and measures its frames.
"""
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import yaml

from img_recog.batch.recorded import RecordingPart
from img_recog.recognition import parameter_file
from img_recog.recognition.areas import ColorExtractor, to_hsv
from img_recog.recognition.fitting.bounds import as_parameters
from img_recog.recognition.fitting.frame_labels import FrameLabels, Labeler
from img_recog.recognition.fitting.histograms import Counter, Histograms
from img_recog.recognition.fitting.limits import blobs
from img_recog.recognition.fitting.samples import SampleError, Samples
from img_recog.recognition.fitting.volume import Box
from img_recog.recognition.recognition_settings import (Color, RecognitionSettings, color_in,
                                                        with_colors)
from img_recog.recordings import parts
from img_recog.recordings.frames import SECOND_NS, Frame, Remarks

# Which samples say something of a frame: those to fit by, or those to check the result.
FIT, CHECK = 0, 1
_UNKNOWN = -1
_UNLABELED = np.zeros((1, 1), bool), np.zeros((1, 1), bool)


class BaseSettings:
    """The settings of a parameter file, or without one those of the article.

    names: of the colors that the result has; min_blob_size: until now.
    """

    def __init__(self, path: str, colors: Sequence[str]):
        """Read a parameter file; path: empty for none; colors: those that are to be fitted.

        Raises ParameterError if it cannot be used.
        """
        self._values, self._settings = (parameter_file.load(path) if path
                                        else ({}, with_colors()()))
        self._colors = tuple(colors)
        known = self._settings.color_names if path else ()
        self.names = (*known, *(name for name in colors if name not in known))
        self.min_blob_size = self._settings.min_blob_size

    def before(self, name: str) -> Optional[Color]:
        """Return the settings of a color until now, None if there are none."""
        return next((color for color in self._settings.colors if color.name == name), None)

    def candidate(self, boxes: Mapping[str, Box]) -> Dict[str, Any]:
        """Return parameters of the colors to be fitted alone; no blob is too small."""
        values = {name: value for name, value in self._values.items()
                  if name.startswith('roi_') or color_in(name) in self._colors}
        return {**values, **_bounds(boxes), parameter_file.COLORS: self._colors}

    def fitted(self, boxes: Mapping[str, Box], limits_px: Mapping[str, int],
               min_blob_size: int) -> Dict[str, Any]:
        """Return the result as parameters of color_extract."""
        limits = {name + '_area_limit': limit_px for name, limit_px in limits_px.items()}
        values = {parameter_file.COLORS: list(self.names), **self._values, **_bounds(boxes),
                  **limits, 'min_blob_size': min_blob_size}
        values[parameter_file.COLORS] = list(self.names)
        return values


def as_yaml(values: Mapping[str, Any], comment: Sequence[str]) -> str:
    """Return parameters as YAML, with lines of comment before them."""
    return ''.join('# {}\n'.format(line) for line in comment) + yaml.safe_dump(
        dict(values), sort_keys=False, default_flow_style=None)


def settings_of(values: Mapping[str, Any]) -> RecognitionSettings:
    """Return the settings in parameters that were made here."""
    return parameter_file.settings_in(dict(values), 'the fitted colors')


def _bounds(boxes: Mapping[str, Box]) -> Dict[str, int]:
    return {name: value for color, box in boxes.items()
            for name, value in as_parameters(color, box).items()}


class Counted(NamedTuple):
    """The histograms of a part by the samples to fit by.

    used: for each set of samples, the entries that were used; remarks: on what was read; error:
    why the samples cannot be used, else empty.
    """

    histograms: Histograms
    used: List[Tuple[str, ...]]
    remarks: Remarks = Remarks()
    error: str = ''


class MeasuredPart(NamedTuple):
    """The measurements of a part: a row for each frame, in the order of their numbers.

    frames: int64, their numbers; times_s: float, from the first frame.
    chosen: int8, FIT or CHECK, -1 without samples; in_view: int8 of shape (frames, colors), 1 or
    0, -1 if unknown.
    pixels: int32 of shape (frames, candidates, colors, sizes, 3): a Score of the labeled ones;
    areas: int32 of shape (frames, candidates, colors, sizes).
    """

    frames: np.ndarray
    times_s: np.ndarray
    chosen: np.ndarray
    in_view: np.ndarray
    pixels: np.ndarray
    areas: np.ndarray


def count(paths: Sequence[str], recorded: RecordingPart, sets: Sequence[Samples], max_pixels: int
          ) -> Counted:
    """Count the labeled pixels of a part.

    paths: of its recording. sets: the samples to fit by and, if there are some, to check.
    """
    labelers = [Labeler(samples, recorded.path) for samples in sets]
    counter = Counter()
    try:
        reader = parts.read(paths[0], recorded.part, max_pixels)
        for frame in reader.read():
            chosen, labels = _labels(sets, labelers, recorded, frame)
            if labels is not None and chosen == FIT:
                counter.add_frame(labels.parts(to_hsv(frame.image, frame.encoding)))
    except SampleError as error:
        return Counted(Histograms({}, {}), [], error=str(error))
    return Counted(counter.result(), [tuple(sorted(labeler.used)) for labeler in labelers],
                   reader.remarks)


def measure(paths: Sequence[str], recorded: RecordingPart, sets: Sequence[Samples],
            max_pixels: int, candidates: Sequence[Mapping[str, Any]],
            sizes: Sequence[int]) -> MeasuredPart:
    """Measure the frames of a part by each of the candidates, for each least size of blobs.

    paths, sets: as for `count`. candidates: parameters of the same colors, with a min_blob_size of
    0.
    """
    labelers = [Labeler(samples, recorded.path) for samples in sets]
    extractors = [ColorExtractor(settings_of(values)) for values in candidates]
    shape = len(extractors), len(sets[FIT].colors), len(sizes)
    rows = []
    for frame in parts.read(paths[0], recorded.part, max_pixels).read():
        chosen, labels = _labels(sets, labelers, recorded, frame)
        pixels, areas = np.zeros((*shape, 3), np.int32), np.zeros(shape, np.int32)
        for index, extractor in enumerate(extractors):
            extractor.measure(frame.image, frame.encoding)
            for number in range(shape[1]):
                is_color, is_not = _UNLABELED if labels is None else labels.truth(number)
                areas[index, number], pixels[index, number] = blobs(
                    extractor.mask(number), sizes, is_color, is_not)
        in_view = [_UNKNOWN] * shape[1] if labels is None else [
            _UNKNOWN if each is None else int(each) for each in labels.is_in_view]
        rows.append((frame.number, (frame.stamp_ns - recorded.start_ns) / SECOND_NS, chosen,
                     in_view, pixels, areas))
    columns = list(zip(*rows)) if rows else [()] * len(MeasuredPart._fields)
    shapes = (), (), (), shape[1:2], (*shape, 3), shape
    kinds = np.int64, float, np.int8, np.int8, np.int32, np.int32
    return MeasuredPart(*(np.array(column, kind).reshape((len(rows), *each))
                          for column, kind, each in zip(columns, kinds, shapes)))


def _labels(sets: Sequence[Samples], labelers: Sequence[Labeler], recorded: RecordingPart,
            frame: Frame) -> Tuple[int, Optional[FrameLabels]]:
    """Return which samples say something of a frame, and what; -1 and None for nothing.

    Raises SampleError if both do: then the check would prove nothing.
    """
    found = []
    height, width = frame.image.shape[:2]
    for chosen, labeler in enumerate(labelers):
        labels = labeler.of(frame.number, (frame.stamp_ns - recorded.start_ns) / SECOND_NS,
                            (height, width))
        if not labels.is_empty:
            found.append((chosen, labels))
    if len(found) > 1:
        raise SampleError('frame {} is in the samples of both {} and {}'.format(
            frame.number, *(samples.path for samples in sets)), 'remove it from one of them')
    return found[0] if found else (_UNKNOWN, None)
