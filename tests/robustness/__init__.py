"""Proofs of robustness, each a command, `python -m robustness.NAME` from tests/, and small in the suite.

kills ends commands at random moments, faults injects failures of the file system, writers lets several write at once,
cluster runs a sweep on a Dask cluster whose processes die. `make soak` runs all of them at full size.
"""
