"""The command line of fit_colors.py."""
import argparse
import os
from typing import Sequence

from img_recog.batch import options as batch_options
from img_recog.recognition.fitting.bounds import OBJECTIVES, PIXELS
from img_recog.recordings import names


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options; paths without a ~."""
    parser = argparse.ArgumentParser(
        prog='fit_colors.py', description='Find the bounds of colors that separate them best in '
        'recordings. Writes a parameter file of color_extract, a report with pictures, and a '
        'table with a row for each frame.', allow_abbrev=False)
    names.add_to(parser)
    parser.add_argument('--samples', metavar='YAML', required=True,
                        help='where in the recordings the colors are')
    parser.add_argument('--check', metavar='YAML', default='',
                        help='samples of other frames, by which the result is only measured')
    parser.add_argument('--colors', metavar='YAML', default='',
                        help='parameter file of color_extract: the result keeps all of it but '
                        'what is fitted, and the report compares both (default: the article\'s '
                        'colors)')
    parser.add_argument('--objective', choices=OBJECTIVES, default=PIXELS,
                        help='what is best: most pixels right; most frames right; or the widest '
                        'margin for other light (default: %(default)s)')
    parser.add_argument('--output', metavar='PREFIX', default='fit_colors',
                        help='beginning of the paths of the results: .yaml, .md, .png, .csv '
                        '(default: %(default)s)')
    batch_options.add_to(parser)
    options = parser.parse_args(arguments)
    for name in ('samples', 'check', 'colors', 'output'):
        setattr(options, name, os.path.expanduser(getattr(options, name)))
    return options
