"""The page of a study, in Markdown: its question, the answer to it, its figure and its table."""

from collections.abc import Iterable, Sequence

from reflexarc_trainer.policy.provenance import commit, versions
from reflexarc_trainer.study.answer import answer
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.measure_words import DIGITS, FIGURE_NAMES, interval_words
from reflexarc_trainer.study.summary import CellSummary, missed_targets
from reflexarc_trainer.study.unit import Measure


def write_page(study: Study, summaries: Sequence[CellSummary], picture: str) -> str:
    """The page.

    Args:
        study: the study.
        summaries: of its cells.
        picture: file name of its figure, in the same folder.
    """
    parts = [
        f"# {study.title}",
        study.question,
        answer(study, summaries),
        f"![{study.title}]({picture})",
        _cells(study, summaries),
        _how(study),
        *_targets(study, list(summaries)),
        "## Where it comes from",
        _origin(study, summaries),
    ]
    return "\n\n".join(parts) + "\n"


def _cells(study: Study, summaries: Sequence[CellSummary]) -> str:
    axes = [axis.label for axis in study.axes]
    figure = FIGURE_NAMES[study.measure]
    head = [*axes, "seeds", f"{figure}, mean [95 %]", "least", "most"]
    with_contacts = study.measure is not Measure.CONTACTS
    head += ["contacts per 100 m"] if with_contacts else []
    with_share = study.measure is not Measure.SHARE_OF_BLIND
    head += ["of blind"] if with_share else []
    head += ["never steering"]
    rows = []
    for summary in summaries:
        row = [*(choice.name for choice in summary.cell.choices), _seeds(summary)]
        row += _figures(summary, DIGITS[study.measure])
        row += [_number(summary.contacts, 2)] if with_contacts else []
        row += [_number(summary.share_of_blind, 3)] if with_share else []
        row += [_number(summary.blind, 1)]
        rows.append(row)
    return _table(head, rows)


def _seeds(summary: CellSummary) -> str:
    words = [str(len(summary.figures))]
    words += [f"{summary.diverged} diverged"] if summary.diverged else []
    words += [f"{summary.missing} missing"] if summary.missing else []
    return ", ".join(words)


def _figures(summary: CellSummary, digits: int) -> list[str]:
    if summary.estimate is None:
        return ["–", "–", "–"]
    mean = interval_words(summary.estimate, digits)
    return [mean, *(_number(edge(summary.figures), digits) for edge in (min, max))]


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _how(study: Study) -> str:
    scale = study.evaluation
    where = f" of `{scale.world}`" if scale.world else ""
    return (
        "Mean: the interquartile mean over seeds, of those that did not diverge; in brackets the "
        "95 % interval of a percentile bootstrap over seeds. Each run is measured greedily in "
        f"{scale.agents:,} test worlds{where}, {scale.steps:,} steps in each after {scale.discard} "
        "that do not count. Never steering: contacts per 100 m of an agent that goes straight on, "
        "in the same worlds. Two cells are told apart where their intervals do not overlap."
    )


def _targets(study: Study, summaries: list[CellSummary]) -> list[str]:
    if not study.targets:
        return []
    missed = missed_targets(study, summaries)
    wanted = "\n".join(f"- {target.cell}: {target.words}" for target in study.targets)
    said = "Missed: " + "; ".join(missed) if missed else "All are met"
    return ["## Targets", wanted, f"{said}."]


def _origin(study: Study, summaries: Sequence[CellSummary]) -> str:
    done = sum(len(summary.figures) + summary.diverged for summary in summaries)
    cost_s = sum((len(s.figures) + s.diverged) * s.unit_s for s in summaries)
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    rows = [
        ("command", f"`reflexarc study {study.name}`"),
        ("runs", f"{done} of {len(study.cells) * len(study.seeds)}"),
        ("time", f"{cost_s / 60:.1f} minutes of one processor"),
        ("commit", f"`{commit() or 'unknown'}`"),
        ("versions", packages),
    ]
    return f"{_table(('', ''), rows)}\n\n```toml\n{study.text.strip()}\n```"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
