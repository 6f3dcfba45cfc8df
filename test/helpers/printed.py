"""Models and settings as text: what is as by default is left out."""
import itertools

import numpy as np

from img_recog.rotations import Transform, to_rpy

PARTS = 'solids', 'looks', 'lights'     # of links


def text(value):
    """Return a value as text; of a NamedTuple, the fields that differ from the default."""
    if isinstance(value, Transform):
        return text([*value.translation, *np.trim_zeros(to_rpy(value.rotation).round(6), 'b')])
    if isinstance(value, np.ndarray):
        if value.shape == (3, 3):       # symmetric
            value = value[np.triu_indices(3)] if np.any(value - np.diag(np.diag(value))) else (
                np.diag(value))
        return text(value.tolist())
    if isinstance(value, float):
        return '{:.6g}'.format(round(value, 9) + 0.0 if abs(value) < 1e6 else value)
    if hasattr(value, '_fields'):
        return ', '.join(fields(value))
    if isinstance(value, dict):
        return ', '.join('{} {}'.format(*map(text, item)) for item in value.items())
    if isinstance(value, (tuple, list)):
        return ' '.join(map(_inside, value)) or '()'
    return str(value)


def fields(value, *others):
    """Return the fields of a NamedTuple with their names, but for those of the names `others`."""
    found = []
    for name, content in zip(value._fields, value):
        if name in value._field_defaults:
            if name not in others and text(content) != text(value._field_defaults[name]):
                found.append('{} {}'.format(name, _inside(content)))
        else:
            found.append(_inside(content))
    return found


def _inside(value):
    is_tuple = hasattr(value, '_fields') and not isinstance(value, Transform)
    return '({})'.format(text(value)) if is_tuple else text(value)


def _rest(link):
    """Return what else a link without parts has than its name, None for one that has parts."""
    return None if any(getattr(link, name) for name in PARTS) else tuple(fields(link)[1:])


def model(found):
    """Return the lines of a Model, but for its name."""
    lines = []
    for rest, links in itertools.groupby(found.links, lambda link: _rest(link) or link.name):
        links = list(links)
        lines.append(', '.join(['link ' + ' '.join(link.name for link in links),
                                *fields(links[0], *PARTS)[1:]]))
        for name in PARTS:
            lines.extend('  {} {}'.format(name[:-1], text(each))
                         for each in getattr(links[0], name))
    lines.extend('joint ' + text(each) for each in found.joints)
    moved = {name: frame for name, frame in found.frames.items() if name != frame.link}
    lines.extend('frame {}: in {}'.format(name, text(frame)) for name, frame in moved.items())
    for name in ('held', 'gears'):
        lines.extend('{}: {}'.format(name.replace('_', ' '), text(each))
                     for each in getattr(found, name))
    lines.extend('contacts of {}: {}'.format(*map(text, each)) for each in found.surfaces.items())
    return lines


def findings(report):
    """Return the lines of the findings of a Report."""
    return ['{}: {}{}'.format(each.kind, each.text(), each.advice and '; ' + each.advice)
            for each in report.findings]


def tree(found):
    """Return the lines of a Tree."""
    return [', '.join(['tree ' + found.name, *fields(found, 'model')[2:]]),
            *('  ' + line for line in model(found.model))]
