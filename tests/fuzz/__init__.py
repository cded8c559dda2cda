"""Hostile input, made up by hypothesis: strategies, what each input is given to, and what must never happen.

tests/fuzz/test_fuzz.py runs a few of each in the suite, and `make fuzz` a thousand, of which it prints how many were
taken and how many refused.
"""
