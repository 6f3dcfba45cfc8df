"""The memory of large images is used again."""
import os
import subprocess
import sys

import pytest

PROGRAM = '''
import resource
import numpy as np
from img_recog.processes import memory
if {}:
    memory.keep()

def faults():
    images = [np.ones(20 << 20, np.uint8) for _ in range(2)]
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
before = [faults() for _ in range(2)][-1]
print((faults() - before) // 1000)
'''

# with huge pages, the kernel maps the same memory with few faults
SMALL_PAGES = {**os.environ, 'NUMPY_MADVISE_HUGEPAGE': '0'}


@pytest.mark.parametrize('is_kept', [True, False])
def test_an_image_after_others_takes_no_new_memory(is_kept):
    printed = subprocess.run([sys.executable, '-c', PROGRAM.format(is_kept)], check=True,
                             stdout=subprocess.PIPE, env=SMALL_PAGES).stdout
    # of 10,000 pages
    assert (int(printed) == 0) == is_kept
