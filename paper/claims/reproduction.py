"""The record of what holds of the paper: `python -m paper.claims.reproduction` writes three pages of docs/.

Every claim has a measurement from committed records and a criterion, so that the verdict follows from the numbers.
The first page has the verdicts and their reasons. The two others, in docs/tables, have the numbers.
"""

from pathlib import Path

import click

from avobench.bench.store.files import write_file
from avobench.bench.store.store import Store
from avobench.reports.quantities import comparable, labelled
from paper.claims import benchmark_claims, example_claims
from paper.claims.claims import Claim, Evidence, Finding
from paper.studies import baseline, detector, misspecification
from paper.tables.real import wrapped

FIRST = "reproduction.md"
NUMBERS = {
    "tables/claims-examples.md": ("Claims on single experiments", example_claims.CLAIMS),
    "tables/claims-benchmark.md": ("Claims on the benchmark", benchmark_claims.CLAIMS),
}
INTRODUCTION = """\
# The paper's claims, one by one

The paper is G. Louppe, J. Hermans, K. Cranmer, *Adversarial Variational Optimization of Non-Differentiable
Simulators*, AISTATS 2019. This page lists each of its claims that says how much, how well or which is better. Behind
the link of a claim stand the command that makes its records, what was measured, and the criterion of the verdict.
`avo-paper` is the algorithm with the paper's hyper-parameters, and `avo` the tuned one ([Methods](methods.md)).

A run that failed counts as infinitely far from the truth. Methods are compared on the targets that all of them have.
`python -m paper.claims.reproduction` writes these pages from the records, and a test compares them."""
BEHIND = "The numbers behind [the verdicts](../reproduction.md), from the committed records."


def pages(evidence: Evidence) -> dict[str, str]:
    """The text of each page, in Markdown, by its path in docs/."""
    measured = {path: [(claim, claim.find(evidence)) for claim in claims] for path, (_, claims) in NUMBERS.items()}
    numbers = {
        path: "\n\n".join([f"# {NUMBERS[path][0]}", BEHIND, *(_section(*one) for one in of_page)]) + "\n"
        for path, of_page in measured.items()
    }
    return {FIRST: _verdicts(measured), **numbers}


def _verdicts(measured: dict[str, list[tuple[Claim, Finding]]]) -> str:
    rows, reasons = ["| claim | verdict |", "|---|---|"], ["## Reasons and remarks"]
    for path, of_page in measured.items():
        for claim, finding in of_page:
            link = f"[{claim.title}]({path}#{_anchor(claim.title)})"
            rows.append(f"| {link} | {finding.verdict} |")
            if claim.why:
                reasons += [f"**{claim.title}.** {claim.why}"]
    return "\n\n".join([INTRODUCTION, "\n".join(rows), reasons[0], *map(wrapped, reasons[1:])]) + "\n"


def _section(claim: Claim, finding: Finding) -> str:
    table = finding.numbers.to_string(index=False, na_rep="-", float_format=lambda value: f"{value:.3g}")
    table = "\n".join(line.rstrip() for line in table.splitlines())
    commands = ", ".join(f"`{command}`" for command in claim.commands)
    return "\n\n".join(
        [
            f"## {claim.title}",
            wrapped(f"{claim.says} ({claim.where})"),
            f"{commands}:",
            f"```\n{table}\n```",
            wrapped(f"**Verdict: {finding.verdict}.** {finding.reading}"),
        ]
    )


def _anchor(title: str) -> str:
    kept = "".join(letter for letter in title.lower() if letter.isalnum() or letter in " -")
    return kept.replace(" ", "-")


def gather(results: Path, studies: Path, ablation: Path) -> Evidence:
    """The records in the three results folders."""
    frame = comparable(labelled(Store(results).read_all()))
    records, undone = Store(studies).read_all(), Store(ablation).read_all()
    response, variances, widths = (each.FILE.read(studies) for each in (detector, baseline, misspecification))
    return Evidence(frame, records, response, undone, variances, widths)


@click.command()
@click.option("--results", type=click.Path(path_type=Path), default=Path("results/reference"), show_default=True)
@click.option("--studies", type=click.Path(path_type=Path), default=Path("results/studies"), show_default=True)
@click.option("--ablation", type=click.Path(path_type=Path), default=Path("results/ablation"), show_default=True)
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("docs"), show_default=True, help="Folder to write."
)
def main(results: Path, studies: Path, ablation: Path, out: Path) -> None:
    """Write the pages on the paper's claims from the records."""
    for path, text in pages(gather(results, studies, ablation)).items():
        write_file(out / path, text.encode())


if __name__ == "__main__":
    main()
