"""Labels of the pixels of a frame, from the samples of its recording."""
from typing import Dict, Iterator, List, Optional, Sequence, Set, Tuple

import cv2
import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.formats import still_images
from img_recog.recognition.fitting.histograms import COLOR, IN_VIEW, NOT, Label
from img_recog.recognition.fitting.samples import (IGNORED, NO_COLOR, Region, SampleError,
                                                   Samples, TimeRange, is_named)

# codes of pixels; that of a color is its number, from 1
_NONE, _IGNORED, _UNLABELED = 0, 254, 255
_CODES = {NO_COLOR: _NONE, IGNORED: _IGNORED}


class FrameLabels:
    """What the samples say of a frame.

    is_in_view: for each color, whether it is in the frame, None if that is not known.
    """

    def __init__(self, samples: Samples, codes: Optional[np.ndarray],
                 is_in_view: Sequence[Optional[bool]]):
        """Combine labels: codes, of the pixels; None if no region is in the frame."""
        self._samples, self._codes, self.is_in_view = samples, codes, tuple(is_in_view)

    @property
    def has_regions(self) -> bool:
        """Whether pixels of the frame are labeled."""
        return self._codes is not None

    @property
    def is_empty(self) -> bool:
        """Whether nothing is known of the frame."""
        return self._codes is None and all(each is None for each in self.is_in_view)

    def truth(self, number: int) -> Tuple[np.ndarray, np.ndarray]:
        """Return where pixels are of a color, and where they are not, as far as that is known.

        Both bool, of the shape of the frame or, without regions, of shape (1, 1).
        """
        codes = self._codes if self._codes is not None else np.full((1, 1), _UNLABELED, np.uint8)
        is_color = codes == number + 1
        is_known = (codes < _IGNORED) | (codes == _UNLABELED) & self._unlabeled_is_not(number)
        return is_color, ~is_color & is_known

    def parts(self, hsv: np.ndarray) -> Iterator[Tuple[Label, np.ndarray]]:
        """Yield labels, and the pixels that have them, uint8 of shape (..., 3).

        hsv: the frame, uint8 of shape (height, width, 3).
        """
        colors, codes, rest = self._samples.colors, self._codes, hsv
        in_view = tuple(color for color, seen in zip(colors, self.is_in_view) if seen)
        if codes is not None:
            for number, color in enumerate(colors, 1):
                yield Label(COLOR, color, in_view), hsv[codes == number]
            yield Label(NOT, '', in_view), hsv[codes == _NONE]
            rest = hsv[codes == _UNLABELED]
        absent = [color for number, color in enumerate(colors) if self._unlabeled_is_not(number)]
        for name in [''] if len(absent) == len(colors) else absent:
            yield Label(NOT, name, in_view), rest
        if codes is None:
            for color in in_view:
                yield Label(IN_VIEW, color, in_view), rest

    def _unlabeled_is_not(self, number: int) -> bool:
        """Return whether the pixels that are in no region are known not to be of a color."""
        if self._codes is None:
            return self.is_in_view[number] is False
        if self.is_in_view[number] is False:
            return True
        has_region = bool((self._codes == number + 1).any())
        return has_region and not self._samples.ignores_unlabeled


class Labeler:
    """Labels the frames of the recording at a path.

    used: the entries of the samples that were needed so far.
    """

    def __init__(self, samples: Samples, recording: str):
        self._samples = samples
        self.used: Set[str] = set()
        own = [sample for name, sample in samples.entries if is_named(recording, name)]
        self._ranges = [each for each in own if isinstance(each, TimeRange)]
        self._regions: Dict[int, List[Region]] = {}
        for region in own:
            if isinstance(region, Region):
                self._regions.setdefault(region.frame, []).append(region)

    def of(self, frame: int, time_s: float, shape: Tuple[int, int]) -> FrameLabels:
        """Return the labels of a frame.

        frame: its number; time_s: since the first frame; shape: height and width in pixels.
        Raises SampleError if a region is not within the frame, or samples contradict each other.
        """
        regions = self._regions.get(frame, [])
        self.used.update(region.entry for region in regions)
        in_view = [self._in_view(color, time_s, regions) for color in self._samples.colors]
        return FrameLabels(self._samples, self._codes(regions, shape) if regions else None,
                           in_view)

    def _in_view(self, color: str, time_s: float, regions: List[Region]) -> Optional[bool]:
        said = {each.is_in_view: each for each in self._ranges
                if each.color == color and each.start_s <= time_s < each.end_s}
        self.used.update(each.entry for each in said.values())
        own = [region for region in regions if region.color == color]
        if own and False in said:
            raise SampleError('{}: {} and {} contradict each other: {} is in frame {}, at {:.3f} '
                              's'.format(self._samples.path, own[0].entry, said[False].entry,
                                         color, own[0].frame, time_s), 'correct one')
        if own or True in said:
            return True
        if False in said or regions and not self._samples.ignores_unlabeled:
            return False
        return None

    def _codes(self, regions: List[Region], shape: Tuple[int, int]) -> np.ndarray:
        codes = np.full(shape, _UNLABELED, np.uint8)
        # what is ignored is so whatever else is said of it
        for region in sorted(regions, key=lambda region: region.color == IGNORED):
            code = _CODES.get(region.color)
            if code is None:
                code = self._samples.colors.index(region.color) + 1
            inside = self._inside(region, shape)
            other = inside & (codes != _UNLABELED) & (codes != code)
            if other.any() and code != _IGNORED:
                raise self._contradiction(region, regions, shape, other.sum() / inside.sum())
            codes[inside] = code
        for region in regions if (codes == _IGNORED).any() else ():
            if region.color in self._samples.colors and (
                    codes[self._inside(region, shape)] == _IGNORED).all():
                raise self._error(region, 'all of it is in a part of the frame that is '
                                  'ignored; make that part smaller, or remove this entry')
        return codes

    def _inside(self, region: Region, shape: Tuple[int, int]) -> np.ndarray:
        """Return where a region is: bool of the shape of the frame, somewhere true."""
        height, width = shape
        if region.mask:
            mask = self._decoded(region)
            if mask.shape[:2] != shape:
                raise self._error(region, 'the mask is {}x{}, the frame {}x{}'.format(
                    mask.shape[1], mask.shape[0], width, height))
            inside = mask.reshape(height, width, -1)[..., :3].any(axis=2)
            if not inside.any():
                raise self._error(region, 'the mask is all black')
            return inside
        corners = np.array(region.outline)
        if (corners < 0).any() or (corners > (width - 1, height - 1)).any():
            raise self._error(region, 'x {:g} to {:g}, y {:g} to {:g} is outside of frame {}, '
                              'which is {}x{}'.format(
                                  corners[:, 0].min(), corners[:, 0].max(), corners[:, 1].min(),
                                  corners[:, 1].max(), region.frame, width, height))
        drawn = np.zeros(shape, np.uint8)
        cv2.fillPoly(drawn, [np.rint(corners).astype(np.int32)], (1,))
        return drawn > 0

    def _decoded(self, region: Region) -> np.ndarray:
        try:
            mask = still_images.decode(region.mask, still_images.DEFAULT_MAX_PIXELS)
        except (UserError, cv2.error) as error:
            raise self._error(region, 'cannot use the mask: {}'.format(one_line(error)))
        if mask is None:
            raise self._error(region, 'the mask is not a PNG that can be read')
        return mask

    def _contradiction(self, region: Region, regions: List[Region], shape: Tuple[int, int],
                       share: float) -> SampleError:
        inside = self._inside(region, shape)
        other = next(each for each in regions if each.color != region.color
                     and (self._inside(each, shape) & inside).any())
        return SampleError('{}: {} and {} contradict each other: {:.1%} of {} is {} by the one '
                           'and {} by the other'.format(
                               self._samples.path, other.entry, region.entry, share, region.entry,
                               other.color, region.color), 'correct one')

    def _error(self, region: Region, problem: str) -> SampleError:
        return SampleError('{}: {}: {}'.format(self._samples.path, region.entry, problem))
