"""What moves when a constant of the score is switched off: `python -m avobench.reports.weighing FOLDER`.

From the records of `avobench.studies.weighing` in this folder, or in `results/weighing`.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from avobench.bench import registry
from avobench.challenge.case import Case
from avobench.reports import reliability
from avobench.studies.weighing import RESULTS

WITHHELD = ", withheld"
"""Of the name of a row: the catalogue lacked what was hidden."""
COLUMNS = {
    "cases": "cases",
    "most probable right": "right",
    "in the 95 % set": "in the set",
    "size": "size",
    "P(truth)": "P(truth)",
    "log score": "log score",
    "calibration error": "calibration error",
}


def cases(folder: Path = RESULTS) -> Iterator[tuple[str, Case]]:
    """Each case with what was switched off and whether the catalogue had what was hidden."""
    for path in sorted(folder.glob("*.jsonl")):
        head, *rows = map(json.loads, path.read_text().splitlines())
        task = registry.build("task", head["task"], {})
        for row in rows:
            yield f"{row['off']}{WITHHELD * (row['kind'] == 'withheld')}", Case(task, row, row["diagnosis"])


def table(folder: Path = RESULTS) -> pd.DataFrame:
    """A row for each thing that was switched off; the last column is the mean P(outside) of what was withheld."""
    known = list(cases(folder))
    off = [name for name in dict.fromkeys(name for name, _ in known) if not name.endswith(WITHHELD)]
    rows = reliability.table(known).set_index("hidden")
    found = rows.loc[off, list(COLUMNS)].rename(columns=COLUMNS)
    withheld = rows.loc[[name + WITHHELD for name in off]]
    return found.assign(**{"withheld: P(outside)": withheld["P(outside)"].to_numpy()}).rename_axis("if")


if __name__ == "__main__":
    found = table(Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS)
    print(found.reset_index().to_string(index=False, float_format=lambda value: f"{value:.2f}"))
