"""Samples that somebody marks in single pictures, as on the page, and their files."""
import os
from typing import Any, Dict, List, NamedTuple, Tuple

import cv2
import numpy as np
import yaml

from img_recog.errors import UserError
from img_recog.recognition.fitting.frame_labels import FrameLabels, Labeler
from img_recog.recognition.fitting.sample_file import OTHER
from img_recog.recognition.fitting.samples import IGNORED, NO_COLOR, Region, Samples, corners

SAMPLES_FILE = 'samples.yaml'
_MASKS = 'masks'        # a folder of its own: who reads all pictures of a folder leaves it out
MAX_PICTURES, MAX_SAMPLES = 8, 40
_MAX_BYTES = 1 << 26    # of all pictures as PNG
_MIN_PX = 30
# how far hue, saturation and value of a region may be from the point that was clicked
_NEAR = 12, 70, 70
_MIN_SATURATION, _MIN_VALUE = 40, 30        # below, a hue says nothing
_HUES, _MIDDLE_HUE = 180, 90


class Sample(NamedTuple):
    """A part of a picture with a color, or with NO_COLOR.

    rectangle: left, top, width and height in pixels; or mask: a PNG as large as the picture.
    """

    number: int
    picture: str
    color: str
    area_px: int
    rectangle: Tuple[int, ...]
    mask: bytes

    def region(self) -> Region:
        """Return it as files of samples have it."""
        return Region('sample {}'.format(self.number), self.color, 0,
                      corners(*self.rectangle) if self.rectangle else (), self.mask)


class Marked(NamedTuple):
    """Pictures as PNG, by the names of their files, and the samples in them.

    rest_is_none: whether what is not marked in a picture with samples has none of the colors; else
    it does not count. next_number: of a sample; last: of the picture that was added last.
    """

    pictures: Dict[str, bytes] = {}
    samples: Tuple[Sample, ...] = ()
    rest_is_none: bool = True
    next_number: int = 1
    last: int = 0

    @property
    def colors(self) -> Tuple[str, ...]:
        """The colors that have samples."""
        return tuple(dict.fromkeys(
            each.color for each in self.samples if each.color != NO_COLOR))

    def as_samples(self) -> Samples:
        """Return what the file of the samples would have."""
        return Samples('the samples', self.colors, not self.rest_is_none, tuple(
            (each.picture, each.region()) for each in self.samples))

    def image(self, picture: str) -> np.ndarray:
        """Return a picture: bgr8, uint8 of shape (height, width, 3)."""
        if picture not in self.pictures:
            raise UserError('this picture is no longer kept', 'go on with the live picture')
        return _decoded(self.pictures[picture])

    def labels(self, picture: str) -> FrameLabels:
        """Return what the samples say of a picture; raise SampleError for a contradiction."""
        height, width = self.image(picture).shape[:2]
        return Labeler(self.as_samples(), picture).of(0, 0.0, (height, width))


def with_picture(marked: Marked, image: np.ndarray) -> Tuple[Marked, str]:
    """Keep one more picture, bgr8, and those that have samples; return its name, too.

    Raises UserError if they would be too many or too large.
    """
    used = {each.picture for each in marked.samples}
    pictures = {name: data for name, data in marked.pictures.items() if name in used}
    last = marked.last + 1
    name = 'picture_{}.png'.format(last)
    pictures[name] = _as_png(image)
    if len(pictures) > MAX_PICTURES or sum(map(len, pictures.values())) > _MAX_BYTES:
        raise UserError('at most {} pictures with {} MB are kept'.format(
            MAX_PICTURES, _MAX_BYTES >> 20), 'save the samples, and remove some')
    return marked._replace(pictures=pictures, last=last), name


def with_click(marked: Marked, picture: str, x: float, y: float, color: str) -> Marked:
    """Add the region around a point; x, y: shares of width and height, 0 to 1.

    The region has pixels like that one, and is connected. Raises UserError if it cannot be used.
    """
    _check_place(x, y)
    image = marked.image(picture)
    height, width = image.shape[:2]
    column, row = min(width - 1, int(x * width)), min(height - 1, int(y * height))
    taken = np.zeros((height, width), np.uint8)
    for each in marked.samples:
        if each.picture == picture:
            own = _inside(each, (height, width))
            if own[row, column]:
                raise UserError('this is sample {} already, which is {}'.format(
                    each.number, each.color), 'remove it, or mark another place')
            taken |= own
    region = _region(image, column, row, taken)
    area_px = np.count_nonzero(region)
    if area_px < _MIN_PX:
        raise UserError('only {} connected pixels are like this one, at least {} are '
                        'needed'.format(area_px, _MIN_PX),
                        'click in the middle of an object, or drag a rectangle')
    return _with_sample(marked, picture, color, area_px, (), _as_png(region))


def with_rectangle(marked: Marked, picture: str, x: float, y: float, width: float, height: float,
                   color: str) -> Marked:
    """Add a rectangle, in shares of width and height of the picture, 0 to 1.

    Raises UserError if it cannot be used.
    """
    _check_place(x, y)
    _check_place(x + width, y + height)
    rows, columns = marked.image(picture).shape[:2]
    left, top = min(columns - 1, round(x * columns)), min(rows - 1, round(y * rows))
    size = round((x + width) * columns) - left, round((y + height) * rows) - top
    if min(size) < 1 or size[0] * size[1] < _MIN_PX:
        raise UserError('the rectangle has {}x{} pixels, at least {} are needed'.format(
            *(max(0, each) for each in size), _MIN_PX), 'drag a larger one')
    return _with_sample(marked, picture, color, size[0] * size[1], (left, top, *size), b'')


def without(marked: Marked, number: int) -> Marked:
    """Remove a sample, if it is there; its picture is kept until the next one comes."""
    return marked._replace(samples=tuple(
        each for each in marked.samples if each.number != number))


def outlines(marked: Marked, picture: str) -> List[List[Tuple[float, float]]]:
    """Return the lines around the samples in a picture, to show them: shares from 0 to 1."""
    found = []
    height, width = marked.image(picture).shape[:2]
    for each in marked.samples:
        if each.picture == picture:
            lines, _ = cv2.findContours(_inside(each, (height, width)), cv2.RETR_EXTERNAL,
                                        cv2.CHAIN_APPROX_SIMPLE)
            for line in lines:
                corners = cv2.approxPolyDP(line, 1 + 0.002 * len(line), True)[:, 0] + 0.5
                found.append([(round(float(x) / width, 4), round(float(y) / height, 4))
                              for x, y in corners])
    return found


def write(marked: Marked, folder: str) -> None:
    """Write all pictures with samples, and the file of the samples, to an empty folder."""
    os.mkdir(os.path.join(folder, _MASKS))
    entries: List[Dict[str, Any]] = []
    contents: Dict[str, bytes] = {}
    for each in marked.samples:
        entries.append({'recording': each.picture, 'color': each.color})
        contents[each.picture] = marked.pictures[each.picture]
        if each.mask:
            entries[-1]['mask'] = '{}/{}.png'.format(_MASKS, each.number)
            contents[entries[-1]['mask']] = each.mask
        else:
            entries[-1]['rectangle'] = list(each.rectangle)
    contents[SAMPLES_FILE] = yaml.safe_dump(
        {'unlabeled': OTHER if marked.rest_is_none else IGNORED, 'samples': entries},
        sort_keys=False, default_flow_style=None).encode()
    for name, content in contents.items():
        with open(os.path.join(folder, name), 'wb') as file:
            file.write(content)


def _with_sample(marked: Marked, picture: str, color: str, area_px: int,
                 rectangle: Tuple[int, ...], mask: bytes) -> Marked:
    """Add a sample; raise SampleError if it contradicts the others."""
    if len(marked.samples) >= MAX_SAMPLES:
        raise UserError('there are {} samples already'.format(MAX_SAMPLES),
                        'save them, and remove some')
    sample = Sample(marked.next_number, picture, color, area_px, rectangle, mask)
    added = marked._replace(samples=(*marked.samples, sample), next_number=sample.number + 1)
    added.labels(picture)
    return added


def _check_place(x: float, y: float) -> None:
    if not (0 <= x <= 1 and 0 <= y <= 1):       # NaN is not, too
        raise UserError('this is outside of the picture', 'mark a place in it')


def _region(image: np.ndarray, column: int, row: int, taken: np.ndarray) -> np.ndarray:
    """Return the pixels that are like one of the image, and connected with it; 255 or 0."""
    hsv = cv2.cvtColor(cv2.medianBlur(image, 5), cv2.COLOR_BGR2HSV)
    hue, saturation, value = map(int, hsv[row, column])
    # hues are an angle: that of the point comes to the middle, far from both ends
    hsv[..., 0] = (hsv[..., 0].astype(int) - hue + _MIDDLE_HUE) % _HUES
    has_hue = saturation >= _MIN_SATURATION and value >= _MIN_VALUE
    near = _NEAR if has_hue else (_HUES, *_NEAR[1:])
    mask = cv2.copyMakeBorder(taken, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=1)
    cv2.floodFill(hsv, mask, (column, row), 0, near, near,
                  4 | 2 << 8 | cv2.FLOODFILL_FIXED_RANGE | cv2.FLOODFILL_MASK_ONLY)
    region = np.where(mask[1:-1, 1:-1] == 2, 255, 0).astype(np.uint8)
    return cv2.morphologyEx(region, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8)) & ~taken


def _inside(sample: Sample, shape: Tuple[int, int]) -> np.ndarray:
    """Return where a sample is: 255 or 0 of the shape of its picture."""
    if sample.mask:
        return _decoded(sample.mask)
    inside = np.zeros(shape, np.uint8)
    left, top, width, height = sample.rectangle
    inside[top:top + height, left:left + width] = 255
    return inside


def _as_png(image: np.ndarray) -> bytes:
    return cv2.imencode('.png', image, (cv2.IMWRITE_PNG_COMPRESSION, 1))[1].tobytes()


def _decoded(png: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
