"""What the .gitignore of the project hides."""
import os
import subprocess

from img_recog_helpers.pages import ROOT


def shown(folder, names):
    """Return those of these files that `git status` would list in a clone.

    folder: where they are made; empty, or not there yet.
    """
    folder.mkdir(exist_ok=True)
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text('')
    git = ['git', '-C', str(folder), '-c',
           'core.excludesFile=' + os.path.join(ROOT, '.gitignore')]
    subprocess.run([*git, 'init', '-q'], check=True)
    status = subprocess.run([*git, 'status', '--porcelain', '-uall'], check=True,
                            stdout=subprocess.PIPE).stdout.decode()
    return sorted(line[3:] for line in status.splitlines())
