"""Much work in many processes, on one machine or on a cluster of Dask."""
