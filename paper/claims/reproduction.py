"""The record of what holds of the paper: `python -m paper.claims.reproduction` prints docs/reproduction.md.

Every claim has a measurement from committed records and a criterion, so that the verdict follows from the numbers.
"""

import textwrap
from pathlib import Path

import click
import pandas as pd

from avobench.bench.store.files import write_file
from avobench.bench.store.store import Store
from avobench.reports.quantities import comparable, labelled
from paper.claims import benchmark_claims, example_claims
from paper.claims.claims import Evidence
from paper.studies import detector

CLAIMS = (*example_claims.CLAIMS, *benchmark_claims.CLAIMS)
INTRODUCTION = """\
# The paper's claims, one by one

Each claim of G. Louppe, J. Hermans, K. Cranmer, *Adversarial Variational Optimization of Non-Differentiable
Simulators*, AISTATS 2019, that says how much, how well or which is better: the command that makes its records, what was
measured, and the verdict that follows by the criterion stated with it. `avo-paper` is the algorithm with the paper's
hyper-parameters, `avo` the tuned one; [methods.md](methods.md) tells what was chosen and why. This
page is the output of

```
python -m paper.claims.reproduction
```

and a test holds it to that. A run that failed counts as infinitely far off; methods are compared on the targets that
all of them have."""


def page(evidence: Evidence) -> str:
    """The whole page, in Markdown."""
    findings = [(claim, claim.find(evidence)) for claim in CLAIMS]
    lines = [INTRODUCTION, "", "| claim | verdict |", "|---|---|"]
    lines += [f"| [{claim.title}](#{_anchor(claim.title)}) | {finding.verdict} |" for claim, finding in findings]
    for claim, finding in findings:
        table = finding.numbers.to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")
        table = "\n".join(line.rstrip() for line in table.splitlines())
        lines += ["", f"## {claim.title}", "", _wrapped(f"{claim.says} ({claim.where})"), ""]
        lines += [", ".join(f"`{command}`" for command in claim.commands) + ":", "", "```", table, "```", ""]
        lines += [_wrapped(f"**Verdict: {finding.verdict}.** {finding.reading}")]
        lines += ["", _wrapped(claim.why)] if claim.why else []
    return "\n".join(lines) + "\n"


def _wrapped(text: str) -> str:
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)


def _anchor(title: str) -> str:
    kept = "".join(letter for letter in title.lower() if letter.isalnum() or letter in " -")
    return kept.replace(" ", "-")


def gather(results: Path, studies: Path, ablation: Path) -> Evidence:
    """The records in the three results folders."""
    frame = labelled(Store(results).read_all())
    frame = pd.concat([comparable(cells) for _, cells in frame.groupby("task", sort=False)])
    return Evidence(frame, Store(studies).read_all(), detector.read(studies), Store(ablation).read_all())


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=Path("results/reference"), show_default=True)
@click.option("--studies", type=click.Path(path_type=Path), default=Path("results/studies"), show_default=True)
@click.option("--ablation", type=click.Path(path_type=Path), default=Path("results/ablation"), show_default=True)
@click.option("--out", type=click.Path(path_type=Path), default=None, help="File to write.  [standard output]")
def main(results: Path, studies: Path, ablation: Path, out: Path | None) -> None:
    """Print docs/reproduction.md from the records."""
    text = page(gather(results, studies, ablation))
    if out is None:
        click.echo(text, nl=False)
    else:
        write_file(out, text.encode())


if __name__ == "__main__":
    main()
