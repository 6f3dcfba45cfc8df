"""A figure of matplotlib as text: where everything is and how it looks."""
import difflib
import os

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex

_RECORDED_WITH = '3.6.'


def described(figure):
    """Return a line for each part of a figure; numbers have four digits."""
    lines = ['figure {} dpi {:g} face {}'.format(
        _numbers(figure.get_size_inches()), figure.dpi, to_hex(figure.get_facecolor()))]
    lines += ['  ' + _text(text) for text in figure.texts]
    lines += ['  ' + _patch(patch) for patch in figure.artists + figure.patches]
    for axes in figure.axes:
        lines += ['  ' + line for line in _axes(axes)]
    return lines


def assert_unchanged(figure, path, folder):
    """Compare a figure with its description in a file; write what it is now to `folder`.

    Skips the test for another version of matplotlib: ticks and sizes of texts differ.
    """
    if not matplotlib.__version__.startswith(_RECORDED_WITH):
        pytest.skip('recorded with matplotlib {}x, this is {}'.format(
            _RECORDED_WITH, matplotlib.__version__))
    new_path = os.path.join(str(folder), os.path.basename(path))
    new = described(figure)
    with open(new_path, 'w') as file:
        file.write('\n'.join(new) + '\n')
    with open(path) as file:
        changes = list(difflib.unified_diff(file.read().splitlines(), new, path, new_path,
                                            lineterm='', n=0))
    assert not changes, 'if this is wanted, copy {} to {}\n{}'.format(new_path, path,
                                                                      '\n'.join(changes))


def _axes(axes):
    yield 'axes {} x {} y {} {} {} frame {} aspect {} anchor {} zorder {:g} patch {}'.format(
        _numbers(axes.get_position().bounds), _numbers(axes.get_xlim()),
        _numbers(axes.get_ylim()), axes.get_xscale(), axes.get_yscale(), axes.get_frame_on(),
        axes.get_aspect(), axes.get_anchor(), axes.get_zorder(), axes.patch.get_visible())
    for axis in (axes.xaxis, axes.yaxis):
        labels = [label.get_text() for label in axis.get_ticklabels()]
        sizes = {label.get_size() for label in axis.get_ticklabels()}
        lengths = {tick.tick1line.get_markersize() for tick in axis.get_major_ticks()}
        shown = {tick.label1.get_visible() for tick in axis.get_major_ticks()}
        yield '  ticks {} {} size {} length {} labels {}'.format(
            _numbers(axis.get_ticklocs()), labels, _numbers(sorted(sizes)),
            _numbers(sorted(lengths)), sorted(shown))
        grid = {(tick.gridline.get_visible(), tick.gridline.get_linewidth())
                for tick in axis.get_major_ticks()}
        yield '  grid {}'.format(sorted(grid))
        yield '  label {!r} size {:g} {}'.format(
            axis.label.get_text(), axis.label.get_size(), to_hex(axis.label.get_color()))
    for title in (axes.title, axes._left_title):        # there is no other access to the left one
        if title.get_text():
            yield '  title ' + _text(title)
    for line in axes.lines:
        yield '  line {} {} {} width {:g} marker {} {:g} alpha {} zorder {:g} {!r}'.format(
            to_hex(line.get_color()), line.get_linestyle(), _sums(line.get_xydata()),
            line.get_linewidth(), line.get_marker(), line.get_markersize(), line.get_alpha(),
            line.get_zorder(), '' if line.get_label()[0] == '_' else line.get_label())
    for patch in axes.patches:
        yield '  ' + _patch(patch)
    for collection in axes.collections:
        paths = [_sums(path.vertices) for path in collection.get_paths()]
        yield '  collection {} {} {} width {} zorder {:g}'.format(
            len(paths), paths[:3], [to_hex(color) for color in collection.get_facecolors()[:3]],
            _numbers(collection.get_linewidths()), collection.get_zorder())
    for image in axes.images:
        yield '  image {} {} {}'.format(image.get_array().shape, _numbers(image.get_extent()),
                                        _numbers(np.mean(image.get_array(), axis=(0, 1))))
    for text in axes.texts:
        yield '  ' + _text(text)
    legend = axes.get_legend()
    if legend is not None:
        columns = getattr(legend, '_ncols', None) or legend._ncol       # newer and older releases
        yield '  legend {} columns {} frame {} pad {:g} loc {} in {} {}'.format(
            [text.get_text() for text in legend.get_texts()], columns,
            legend.get_frame_on(), legend.borderaxespad, legend._loc,
            _numbers(legend.get_bbox_to_anchor().transformed(axes.transAxes.inverted()).bounds),
            _numbers({text.get_size() for text in legend.get_texts()}))


def _text(text):
    return '{!r} at {} size {:g} {} {} {} {}'.format(
        text.get_text(), _numbers(text.get_position()), text.get_size(), text.get_weight(),
        to_hex(text.get_color()), text.get_ha(), text.get_visible())


def _patch(patch):
    transform = patch.get_transform() if patch.axes is None else patch.get_patch_transform()
    corners = transform.transform(patch.get_path().vertices)
    return 'patch {}-{} face {} edge {} fill {} width {:g} {} alpha {} zorder {:g}'.format(
        _numbers(corners.min(axis=0)), _numbers(corners.max(axis=0)),
        to_hex(patch.get_facecolor()), to_hex(patch.get_edgecolor()), patch.get_fill(),
        patch.get_linewidth(), patch.get_linestyle(), patch.get_alpha(), patch.get_zorder())


def _sums(points):
    """Return the corners of a box around points, and sums that change with every coordinate."""
    points = np.asarray(points, float)
    if not len(points):
        return 'nothing'
    weights = np.arange(1, len(points) + 1)
    return '{}-{} {}'.format(_numbers(points.min(axis=0)), _numbers(points.max(axis=0)),
                             _numbers(weights @ points))


def _numbers(values):
    return '({})'.format(', '.join('{:.4g}'.format(round(float(value), 9) + 0.0)
                                   for value in values))
