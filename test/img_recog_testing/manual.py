"""./run manual in a shell that sees, beside this package, only packages of a test."""
import os
import subprocess

from img_recog_testing.pages import ROOT

_PACKAGE = """<package format="2">
  <name>{}</name><version>1.0.0</version><description>-</description><license>-</license>
  <maintainer email="nobody@example.com">nobody</maintainer>
</package>"""


class Workspace:
    """Packages in a folder. env: of the shell."""

    def __init__(self, folder, env):
        self.folder = folder / 'packages'
        self.env = dict(env, ROS_PACKAGE_PATH=str(self.folder))

    def add(self, *names):
        """Write packages without content."""
        for name in names:
            self.write(name + '/package.xml', _PACKAGE.format(name))

    def write(self, path, text):
        """Write a file; one that ends with .py is a program."""
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text.replace('{python}', os.path.join(ROOT, '.venv', 'bin', 'python3')))
        file.chmod(0o755)

    def manual(self, *words):
        """Run ./run manual without page and windows; return its exit code and its output."""
        done = subprocess.run(['./run', 'manual', *map(str, words), 'web:=false', 'gui:=false'],
                              cwd=ROOT, env=self.env, check=False, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=600)
        return done.returncode, done.stdout.decode(errors='replace')
