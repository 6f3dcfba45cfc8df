"""The settings of colors before they are fitted, and afterwards."""
from typing import Any, Dict, Mapping, Optional, Sequence

import yaml

from img_recog.recognition import parameter_file
from img_recog.recognition.fitting.bounds import as_parameters
from img_recog.recognition.fitting.volume import Box
from img_recog.recognition.recognition_settings import (Color, RecognitionSettings, color_in,
                                                        with_colors)


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
