"""The picture of a drive that was recorded, drawn by plot.py.

In a process: matplotlib takes more memory than all of the page.
"""
import os
import subprocess
import tempfile

from img_recog.errors import UserError, one_line

TIMEOUT_S = 120.0


def draw(path: str, robot: str, colors: str) -> str:
    """Draw the drive of a robot in a bag; return the path of the picture, beside the bag.

    robot: its namespace, '' for the only one. colors: the text of a parameter file, '' for those
    of the article. Waits: not for the event loop. Raises UserError if it cannot be drawn.
    """
    output = os.path.splitext(path)[0] + '.png'
    words = ['rosrun', 'img_recog', 'plot.py', path, output]
    with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
        file.write(colors)
        file.flush()
        words += ['--robot', robot] if robot else []
        words += ['--colors', file.name] if colors else []
        try:
            done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, timeout=TIMEOUT_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise UserError('no picture of {}: {}'.format(path, one_line(error)))
    if done.returncode:
        lines = done.stderr.decode(errors='replace').split('\n')
        reason = next((line for line in reversed(lines) if line.strip()),
                      'exit code {}'.format(done.returncode))
        raise UserError(reason.replace('plot.py: error: ', ''))
    return output
