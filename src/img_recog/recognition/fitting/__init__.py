"""Fits the bounds of colors to samples: the best box is searched in histograms of HSV."""
