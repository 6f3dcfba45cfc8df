"""Much work in many processes, on one machine or on a cluster of Dask."""
import os

# There are as many processes as cores. llvmpipe and numpy read this when they are loaded; with 0,
# llvmpipe draws in the thread that asks for it.
for _name, _threads in (('LP_NUM_THREADS', '0'), ('OMP_NUM_THREADS', '1'),
                        ('OPENBLAS_NUM_THREADS', '1')):
    os.environ.setdefault(_name, _threads)
