"""`avobench status`, `avobench export` and `avobench pack`: what is in a results folder."""

import sys
from pathlib import Path

import click

from avobench.bench.store.files import require_folder, write_file
from avobench.bench.store.frame import as_csv, to_frame
from avobench.bench.store.status import Status, reason
from avobench.bench.store.store import Store
from avobench.cli import listing
from avobench.cli.options import PATH, RESULTS
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
@click.option("--out", type=PATH, required=True, help="File to write.")
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


@click.command()
@RESULTS
def pack(results: Path) -> None:
    """Move the records of a results folder from one file per cell into one table, records.parquet.

    All commands read the table as they read the files. A later run adds files again, until they are packed too.
    """
    store = Store(results)
    packed = store.pack()
    say(f"{packed.folded} files packed, {packed.rows} records in {store.table}")
    for path, fault in packed.damaged.items():
        say(f"avobench: {path} {fault}; left as it is, {store.remedy(path, fault)}", err=True)
    if packed.damaged:
        sys.exit(1)
