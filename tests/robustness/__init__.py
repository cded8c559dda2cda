"""Proofs of robustness, small in the suite.

kills ends commands before each of their operations on files, faults injects failures of the file system, writers lets
several write at once, cluster runs a sweep on a Dask cluster whose processes die. `make soak` runs all at full size.
"""
