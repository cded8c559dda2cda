"""Data sets of other fields with the answers that were written down first, by which the diagnosis is judged.

`opened` ones are what it is developed on. `sealed` ones were written without sight of the code; a finished version is
run on them once, and then they are opened.
"""
