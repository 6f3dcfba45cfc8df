"""The .ini files of calibrations: the format of Videre, as camera_calibration_parsers has it."""
import re
from typing import Any, Dict, Mapping, Sequence

_COMMENT, _SECTION = re.compile('#.*'), re.compile(r'\[([^][\n]*)\]')
_LABEL = re.compile(r'\b(width|height|camera\s+matrix|distortion|rectification|projection)\b')
# the key of the same matrix in a YAML file, by its label
_KEYS = {'camera matrix': 'camera_matrix', 'distortion': 'distortion_coefficients',
         'rectification': 'rectification_matrix', 'projection': 'projection_matrix'}


def parse(text: str) -> Dict[str, Any]:
    """Return the content of a file with the keys of a YAML file; what is missing is left out.

    [image] has the size, [externals] is not used, and another section is named like the camera.
    No section names the distortion model.
    """
    sections = _SECTION.split(_COMMENT.sub('', text))
    content: Dict[str, Any] = {}
    for name, body in zip(sections[1::2], sections[2::2]):
        if name == 'externals':
            continue
        if name != 'image':
            content['camera_name'] = name
        words = _LABEL.split(body)
        for label, numbers in zip(words[1::2], words[2::2]):
            label = ' '.join(label.split())
            if label in _KEYS:
                content[_KEYS[label]] = {'data': numbers.split()}
            elif numbers.strip().isdecimal():
                content['image_' + label] = int(numbers)
    return content


def text_of(content: Mapping[str, Any]) -> str:
    """Return a file with this content; the distortion model is left out."""
    lines = ['[image]', '', 'width', str(content['image_width']), '', 'height',
             str(content['image_height']), '', '[{}]'.format(content['camera_name'])]
    for label, key in _KEYS.items():
        data, columns = content[key]['data'], content[key]['cols']
        lines += ['', label, *(_row(data[start:start + columns])
                               for start in range(0, len(data), columns))]
    return '\n'.join(lines) + '\n'


def _row(numbers: Sequence[float]) -> str:
    return ' '.join(map(repr, numbers))
