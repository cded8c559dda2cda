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
    """Put the records of a results folder into one table, records.parquet, in place of a file each.

    All commands read it as they read the files. What a later run makes is in files of its own until it is packed too.
    """
    store = Store(results)
    packed = pack_store(store)
    say(f"{packed.folded} files packed, {packed.rows} records in {store.table}")
    for path, fault in packed.damaged.items():
        say(f"avobench: {path} {fault}; left as it is, {store.remedy(path, fault)}", err=True)
    if packed.damaged:
        sys.exit(1)
