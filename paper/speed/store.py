"""How the commands that read a store grow with the number of its records: `make bench-store`.

The records are copies of those in results/reference, each as another repetition with an id of its own, packed in one
table. Every command runs in a process of its own; its seconds of processor and its largest memory are measured.
"""

import multiprocessing
import os
import sys
import tempfile
from itertools import count
from pathlib import Path

import click
import pandas as pd

from avobench.bench.store.packed import Row, write_rows
from avobench.bench.store.record import IDENTITY, encode, file_name, identity_hash
from avobench.bench.store.store import Store
from avobench.tasks.errors import AvobenchError
from paper.speed.growth import exponent, show

REFERENCE = Path("results/reference")
STEP = 10**6
"""Between the repetitions that the copies of two repetitions begin with: larger than the number of copies."""
COMMANDS = {
    "status": "status --results {store}",
    "export": "export --format parquet --out {out}/t.parquet --results {store}",
    "figure benchmark": "figure benchmark --results {store} --out {out}",
    "figure efficiency": "figure efficiency --results {store} --out {out}",
    "report": "report --results {store} --out {out}",
}
"""What reads all records, for a store and a folder to write to."""


def make(path: Path, size: int, source: Path = REFERENCE) -> None:
    """A packed store of `size` records at `path`: copies of the sound ones of `source`, all different."""
    store, kept, rows = Store(path, create=True), Store(source).read_all(), []
    for repetition in count():
        for record in kept:
            if len(rows) == size:
                write_rows(store.table, rows)
                return
            copy = {**record, "repetition": STEP * record["repetition"] + repetition}
            copy["id"] = identity_hash({name: copy[name] for name in IDENTITY if name in copy})
            rows.append(Row(file_name(copy), encode(copy).decode()))


def measure(arguments: list[str]) -> tuple[float, float]:
    """Seconds of processor and the largest memory [MiB] of a command. Raises AvobenchError if it fails."""
    quiet = [(os.POSIX_SPAWN_OPEN, stream, os.devnull, os.O_WRONLY, 0) for stream in (1, 2)]
    command = [sys.executable, "-m", "avobench", *arguments]
    child = os.posix_spawn(sys.executable, command, os.environ, file_actions=quiet)
    _, status, used = os.wait4(child, 0)
    if status:
        raise AvobenchError(f"avobench {' '.join(arguments)} ended with exit code {os.waitstatus_to_exitcode(status)}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def table(sizes: tuple[int, ...], folder: Path, source: Path = REFERENCE) -> pd.DataFrame:
    """A row a command and size, told on standard error as soon as it is measured."""
    rows = []
    for size in sizes:
        # In a process of its own: what this one has in memory would count for those that it starts.
        maker = multiprocessing.get_context("spawn").Process(target=make, args=(folder / str(size), size, source))
        maker.start()
        maker.join()
        for name, arguments in COMMANDS.items():
            out = folder / f"out-{size}"
            out.mkdir(exist_ok=True)
            seconds, memory = measure(arguments.format(store=folder / str(size), out=out).split())
            page = out / "index.html"
            size_of_page = page.stat().st_size / 2**20 if name == "report" else float("nan")
            rows.append({"command": name, "records": size, "seconds": seconds, "memory [MiB]": memory})
            rows[-1]["page [MiB]"] = size_of_page
            click.echo(f"{name} of {size} records: {seconds:.1f} s, {memory:.0f} MiB", err=True)
    return pd.DataFrame(rows)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--largest", type=int, default=100_000, show_default=True, help="Records of the largest store.")
def main(largest: int) -> None:
    """Print seconds and memory of each command against the number of records, and the exponents."""
    sizes = tuple(size for size in (1000, 10_000, 100_000) if size <= largest)
    with tempfile.TemporaryDirectory() as folder:
        found = table(sizes, Path(folder))
    show(found)
    for name, part in found.groupby("command", sort=False):
        last, what = part.iloc[-2:], []
        for column in ("seconds", "memory [MiB]"):
            what.append(f"{column} ~ records^{exponent(last['records'], last[column]):.2f}")
        click.echo(f"{name}, from {last['records'].iloc[0]} to {last['records'].iloc[1]}: {', '.join(what)}")


if __name__ == "__main__":
    main()
