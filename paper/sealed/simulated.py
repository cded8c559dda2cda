"""All simulated cases: a hundred of twenty simulators, of which each has a null.

Written without sight of the code.
"""

from paper.sealed import counts, one_feature, several
from paper.sealed.case import Sealed

CASES: list[Sealed] = [*counts.CASES, *one_feature.CASES, *several.CASES]
