"""Fits the bounds of colors to samples: histograms add up, and a box of HSV is searched in them."""
