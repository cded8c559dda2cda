"""`avobench diagnose`: from a file of measured events to what the simulator lacks."""

import io
import json
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
from numpy.typing import NDArray

from avobench.bench import registry
from avobench.bench.atomic import write_atomically
from avobench.tasks import Task
from avobench.tasks.errors import UsageError

if TYPE_CHECKING:
    from avobench.effects import Effect

TRIED = 50
"""Events on which an effect of the user's is tried."""


@click.command()
@click.option("--task", "spec", required=True, metavar="NAME", help="Task, module:Class, or a model.json.")
@click.option("--data", required=True, metavar="FILE", help="Measured events, one row each; file.root:tree for ROOT.")
@click.option("--out", required=True, type=click.Path(path_type=Path), metavar="DIR", help="Folder of the results.")
@click.option("--columns", default=None, metavar="A,B,...", help="Columns or branches to read, in this order.")
@click.option("--drop-invalid", is_flag=True, help="Leave out rows that hold NaN or infinite values.")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True)
@click.option("--alpha", type=float, default=0.05, show_default=True, help="Rate of false alarms, at most.")
@click.option("--max-effects", type=click.IntRange(0), default=3, show_default=True, help="Effects to add at most.")
@click.option("--simulations", type=click.IntRange(1), default=None, help="Simulated events, about.  [what it takes]")
@click.option(
    "--fit", default="surrogate", show_default=True, metavar="NAME", help="Method that looks for theta first."
)
@click.option("--effects", default=None, metavar="A,B,...", help="Effects of the catalogue to try.  [all that apply]")
@click.option("--effect", "own", multiple=True, metavar="EFFECT", help="module:Class or file.py:Class; repeatable.")
@click.option("--jobs", "-j", type=click.IntRange(1), default=1, show_default=True, help="Worker processes.")
def diagnose(
    spec: str,
    data: str,
    out: Path,
    columns: str | None,
    drop_invalid: bool,
    seed: int,
    alpha: float,
    max_effects: int,
    simulations: int | None,
    fit: str,
    effects: str | None,
    own: tuple[str, ...],
    jobs: int,
) -> None:
    """Say whether measured events disagree with a simulator, where, which effect is missing, and add it.

    Writes diagnosis.json, model.json (a task, for wherever a task is accepted), and correction.npz, weights for
    simulated events, where the catalogue does not explain all.
    """
    from avobench.bench.events import check_events, read_events
    from avobench.diagnosis import loop
    from avobench.diagnosis.answer import quoted as values
    from avobench.diagnosis.answer.model_file import describe, kept
    from avobench.effects.catalogue import catalogue, chosen
    from avobench.reports import diagnosis as report

    task = registry.build("task", spec, {})
    registry.require_packages("task", task)
    known = registry.blamed(lambda: catalogue(task), f"task '{spec}'")
    wanted = {effect.name for effect in known} if effects is None else [name.strip() for name in effects.split(",")]
    selected = chosen(known, wanted, spec)
    theirs: dict[str, tuple[str, Effect]] = {}
    for name in own:
        effect = registry.effect(name)
        if effect.name in theirs or effect.name in {one.name for one in known}:
            raise UsageError(f"effect '{name}': there is another effect named {effect.name}; give it another name")
        tried(name, effect, task)
        theirs[effect.name] = name, effect
        selected.append(effect)
    x, warnings = check_events(
        task, read_events(data, [c.strip() for c in columns.split(",")] if columns else None), drop_invalid=drop_invalid
    )
    for warning in warnings:
        click.echo(f"warning: {warning}", err=True)
    for name, effect in theirs.values():  # what no file can keep would else show when all is done
        registry.blamed(lambda effect=effect, name=name: kept(effect.adapted(x), task, name), f"effect '{name}'")
    writable(out)
    result = loop.diagnose(
        task,
        x,
        seed=seed,
        alpha=alpha,
        max_effects=max_effects,
        num_simulations=simulations,
        fit=fit,
        effects=selected,
        jobs=jobs,
    )
    diagnosis = result.diagnosis
    diagnosis.notes[:0] = warnings
    for name in ("diagnosis.json", "correction.npz"):  # of another run, to which what follows does not belong
        (out / name).unlink(missing_ok=True)
    report.write(task, result, out, f"{Path(data).name} against {spec}")
    sources = {name: source for name, (source, _) in theirs.items()}
    std = values.scaled_std(result.fit)
    std[: result.fit.model.num_theta] = [v.std for v in (diagnosis.theta_after or diagnosis.theta_before).values()]
    model = describe(result.fit, std, spec, sources)
    write_atomically(out / "model.json", (model.model_dump_json(indent=1) + "\n").encode())
    if result.correction is not None:
        content = io.BytesIO()
        np.savez_compressed(content, x=result.correction.x, weights=result.correction.weights)
        write_atomically(out / "correction.npz", content.getvalue())
    # Last, so that a folder with a diagnosis has all that belongs to it.
    write_atomically(out / "diagnosis.json", (json.dumps(diagnosis.model_dump(mode="json"), indent=1) + "\n").encode())
    click.echo(summary(diagnosis))


def tried(name: str, effect: "Effect", task: Task) -> None:
    """Try an effect of the user's on a few events. Raises UsageError if it raises or makes other events than the task.

    Before anything is fitted, since a fault would else show minutes later; `avobench check effect` tries much more.
    """
    rng = np.random.default_rng(0)
    theta = task.prior.sample(TRIED, rng)

    def apply() -> NDArray:
        phi = rng.uniform(*np.transpose([(p.low, p.high) for p in effect.parameters]), (TRIED, len(effect.parameters)))
        return np.asarray(effect.apply(task.simulate, theta, phi, rng))

    x = registry.blamed(apply, f"effect '{name}'")
    if x.shape != (TRIED, task.num_features):
        raise UsageError(f"effect '{name}' makes events of shape {x.shape}, not {(TRIED, task.num_features)}")
    if x.dtype != np.dtype(task.dtype) or not np.isfinite(x).all():
        raise UsageError(
            f"effect '{name}' must make finite events of {np.dtype(task.dtype)}, and makes {x.dtype}: {x[0]}"
        )
    if effect.parameters[0].null is None:
        raise UsageError(f"effect '{name}': its strength, {effect.parameters[0].name}, has no null value")


def writable(folder: Path) -> None:
    """Make the folder. Raises UsageError where files cannot be written in it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / ".writable", b"").unlink()
    except OSError as error:
        raise UsageError(f"the folder {folder} cannot be used: {error.strerror or error}") from error


def summary(result) -> str:
    """The diagnosis in at most a screen."""
    gates = ", ".join(f"{name} p = {gate.p_value:.2g}" for name, gate in result.gates.items())
    lines = [f"{result.verdict} ({result.num_events} events, {gates}; alpha = {result.alpha:g})"]
    gap = result.gap_before
    line = f"gap on events kept aside, chi2/ndf: {gap.value:.2f} [{gap.low:.2f}, {gap.high:.2f}]"
    if (gap := result.gap_after) is not None:
        line += f" -> {gap.value:.2f} [{gap.low:.2f}, {gap.high:.2f}], p = {result.p_value_after:.2g}"
    lines.append(line)
    for found in result.effects:
        values = ", ".join(
            f"{name} = {p.value:.4g}"
            + (f" +- {p.std:.2g}" if p.std is not None else "")
            + f" {p.unit}" * (p.unit != "1")
            for name, p in found.parameters.items()
        )
        lines.append(f"missing: {label(found)}: {values}")
        if found.tied_with:
            lines.append(f"  these data do not tell it from {', '.join(map(label, found.tied_with))}")
    for region in result.regions[:4]:
        where = f"{region.feature} " if region.feature else ""
        lines.append(f"{region.kind} at {where}{region.low:.4g} to {region.high:.4g}: {abs(region.z):.1f} sigma")
    after = result.theta_after or {}
    for name, value in result.theta_before.items():
        line = f"{name} = {value.value:.5g} +- {value.std:.2g}"
        lines.append(line + (f" -> {after[name].value:.5g} +- {after[name].std:.2g}" if name in after else ""))
    lines += [f"note: {note}" for note in result.notes[:6]]
    lines.append(f"{result.num_simulations} simulated events, {result.seconds:.1f} s")
    return "\n".join(lines)


def label(named) -> str:
    """An effect and what it acts on, in words."""
    return named.name if named.feature is None else f"{named.name} on {named.feature}"
