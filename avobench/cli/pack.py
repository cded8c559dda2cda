"""`avobench pack`: the records of a folder in one table."""

import sys
from pathlib import Path

import click

from avobench.bench.store.pack import pack as pack_store
from avobench.bench.store.store import Store
from avobench.cli.options import RESULTS
from avobench.cli.terminal import say


@click.command()
@RESULTS
def pack(results: Path) -> None:
    """Move the records of a results folder from one file per cell into one table, records.parquet.

    All commands read the table as they read the files. A later run adds files again, until they are packed too.
    """
    store = Store(results)
    packed = pack_store(store)
    say(f"{packed.folded} files packed, {packed.rows} records in {store.table}")
    for path, fault in packed.damaged.items():
        say(f"avobench: {path} {fault}; left as it is, {store.remedy(path, fault)}", err=True)
    if packed.damaged:
        sys.exit(1)
