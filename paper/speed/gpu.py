"""What a GPU is worth to the methods that can use one: `make bench-gpu`, on a machine that has one.

The same cells are carried out three times, one after the other: on the processor with a process per core, on the GPU
all in one process, and on the GPU one by one in as many processes as there are cores, which share it. Records, sweeps
and the name of the machine stay in a folder, from which the table is printed.
"""

import json
import subprocess
from pathlib import Path

import click
import joblib
import numpy as np
import pandas as pd

from avobench import Workers, records, run
from avobench.bench.store.store import Store
from avobench.cli.main import main
from avobench.methods.device import require_device
from avobench.tasks.errors import UsageError
from paper.tasks import Warped32, spec

FOLDER = Path("results/gpu")
ARRANGEMENTS = {
    "processor": ("cpu", Workers()),
    "GPU, one process": ("cuda", Workers(jobs=1, backend="together")),
    "GPU, shared": ("cuda", Workers(backend="together", group=1)),
}
CASES = {
    "warped-20": ("warped-20", "avo", 160_000, 100_000, ()),
    "warped-32": (spec(Warped32), "avo", 160_000, 100_000, ()),
    "image": ("alignment", "avo", 40_000, 10_000, ("avo.symmetric=false",)),
    "image, paper": ("alignment", "avo-paper", 40_000, 10_000, ()),
}
"""Task, method, budget, observed events and settings. The images are fewer, as Pythia takes longer than the methods."""


def carry_out(folder: Path, targets: str, cases: tuple[str, ...]) -> None:
    """Carry out what the folder lacks, and write down the machine. Raises UsageError where there is no GPU."""
    import torch

    try:
        require_device("cuda")
    except ValueError as error:
        raise UsageError("PyTorch finds no CUDA device on this machine, which --run needs") from error
    machine = {
        "GPU": torch.cuda.get_device_name(),
        "CUDA": torch.version.cuda,
        "processor": subprocess.run(["lscpu"], capture_output=True, text=True, check=True).stdout,
        "cores": joblib.cpu_count(),
    }
    machine["processor"] = machine["processor"].partition("Model name:")[2].partition("\n")[0].strip()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "machine.json").write_text(json.dumps(machine, indent=1) + "\n")
    for case in cases or CASES:
        task, method, budget, observations, settings = CASES[case]
        for name, (device, workers) in ARRANGEMENTS.items():
            run(
                task,
                method,
                targets,
                budget=budget,
                observations=observations,
                settings=settings,
                device=device,
                workers=workers,
                results=folder / case / name,
            )


def table(folder: Path) -> pd.DataFrame:
    """A row per case and arrangement: seconds, their ratio to the processor's, and how far the estimates are apart.

    `cell [s]` is the time in the method per cell, without the simulator; `all [s]` is the time until the last cell was
    finished, the simulator and the start of the processes included; `processor / cell` and `processor / all` are the
    ratios. `apart` is the largest difference from the
    processor's estimate in the standard deviations that it quotes: the median of the cells.
    """
    rows = []
    for case in CASES:
        kept = {name: Store(folder / case / name) for name in ARRANGEMENTS if (folder / case / name).exists()}
        for name, store in kept.items():
            frame = records(folder / case / name).sort_values("target")
            rows.append(
                {
                    "case": case,
                    "where": name,
                    "cells": len(frame),
                    "ok": (frame["status"] == "ok").sum(),
                    "cell [s]": frame["method_seconds"].mean(),
                    "all [s]": sum(sweep["wall_seconds"] for sweep in store.sweeps()),
                    "estimates": frame.filter(regex=r"^theta_hat_\d").to_numpy(),
                    "std": frame.filter(regex=r"^std_\d").to_numpy(),
                }
            )
    of = pd.DataFrame(rows)
    first = of.groupby("case", sort=False)[["cell [s]", "all [s]", "estimates", "std"]].transform("first")
    for what in ("cell", "all"):
        of[f"processor / {what}"] = first[f"{what} [s]"] / of[f"{what} [s]"]
    pairs = zip(of["estimates"], first["estimates"], first["std"], strict=True)
    of["apart"] = [np.median(np.abs((a - b) / std).max(axis=1)) for a, b, std in pairs]
    return of.drop(columns=["estimates", "std"])


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("folder", type=click.Path(path_type=Path), default=FOLDER)
@click.option("--run", "asked", is_flag=True, help="Carry out what the folder lacks; this needs a GPU.")
@click.option("--targets", default="0-14", show_default=True)
@click.option("--case", "cases", type=click.Choice(list(CASES)), multiple=True, help="Of all cases these.")
def gpu(folder: Path, asked: bool, targets: str, cases: tuple[str, ...]) -> None:
    """Print what the cells took on the processor and on the GPU."""
    if asked:
        carry_out(folder, targets, cases)
    if not (folder / "machine.json").exists():
        raise UsageError(f"no records in {folder}; --run makes them on a machine with a GPU")
    machine = json.loads((folder / "machine.json").read_text())
    click.echo(", ".join(f"{name} {value}" for name, value in machine.items()) + "\n")
    click.echo(table(folder).to_string(index=False, float_format="{:.3g}".format))


if __name__ == "__main__":
    main(gpu)
