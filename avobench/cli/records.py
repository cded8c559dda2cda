"""`avobench status` and `avobench export`: what is in a results folder."""

from pathlib import Path

import click

from avobench.bench.store.files import require_folder, write_file
from avobench.bench.store.status import Status, reason
from avobench.bench.store.store import Store
from avobench.bench.store.table import as_csv, to_frame
from avobench.cli import listing
from avobench.cli.options import RESULTS
from avobench.cli.terminal import say
from avobench.tasks.errors import UsageError


@click.command()
@RESULTS
def status(results: Path) -> None:
    """Summarise the records of a results folder, and list failed cells and damaged files."""
    records = Store(results).read_all(traces=False)
    say(listing.status_table(records))
    for record in records:
        if record["status"] != Status.OK:
            cell = "{task} {method} target {target} repetition {repetition}".format(**record)
            say(f"{cell}: {reason(record)}")


@click.command()
@click.option("--format", "kind", type=click.Choice(["csv", "parquet"]), required=True, help="Format of the file.")
@click.option("--out", type=click.Path(path_type=Path), required=True, help="File to write.")
@RESULTS
def export(kind: str, out: Path, results: Path) -> None:
    """Write all records as one table, one row per cell."""
    require_folder(out.parent, make=False)
    if out.is_dir():
        raise UsageError(f"{out} is a folder; --out takes the file to write")
    frame = to_frame(Store(results).read_all(traces=False))
    content = as_csv(frame) if kind == "csv" else frame.to_parquet(index=False)
    write_file(out, content)
    say(f"{len(frame)} rows in {out}")
