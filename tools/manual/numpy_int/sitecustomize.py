"""Gives NumPy 1.24 and later the name numpy.int (int), which detect_lane of AutoRace uses."""
import numpy

if not hasattr(numpy, 'int'):
    setattr(numpy, 'int', int)
