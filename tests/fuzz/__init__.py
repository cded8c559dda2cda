"""Hostile input, made up by hypothesis: strategies, what each input is given to, and what must never happen.

`python -m fuzz` from tests/ prints how many of each kind were taken and how many refused; tests/fuzz/test_fuzz.py runs
a few of each in the suite; `python -m fuzz.guided` lets a coverage-guided fuzzer change files of events.
"""
