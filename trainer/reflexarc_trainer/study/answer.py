"""The answer to a study's question in words, computed from its results.

Cells are compared along one axis: that of the value which the question asks about (`asked` of the
study's file), or else that of numbers, or the last; those that differ in another axis are answered
for one by one. What a cell is compared with is the asked value, or else the best one. Two cells are
told apart where their 95 % intervals do not overlap: cautious, as two means may differ where their
intervals just do.
"""

from collections.abc import Iterator, Sequence

from reflexarc_sim_bridge.evaluation.scoring.statistics import Estimate
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.measure_words import (
    DIGITS,
    FIGURE_NAMES,
    higher_is_better,
    interval_words,
)
from reflexarc_trainer.study.summary import CellSummary
from reflexarc_trainer.study.unit import Measure

_TIMES = 2.0
"""From this ratio on it is said as times."""

_Known = tuple[str, Estimate]
"""Name of a value on the axis along which cells are compared, and what it came to."""


def answer(study: Study, summaries: Sequence[CellSummary]) -> str:
    """The answer: a sentence for each group of cells, and one about an agent that never steers."""
    groups = _groups(study, summaries)
    sentences = [_sentence(study, name, known) for name, known in groups.items() if known]
    missing = [_quoted(s.cell.name) for s in summaries if s.estimate is None]
    if missing:
        sentences.append(f"Without a figure: {', '.join(missing)}.")
    return " ".join([*sentences, *_about_blind(study, summaries)])


def asked_axis(study: Study) -> int:
    """The axis along which cells are compared: that of the asked value, of numbers, or the last."""
    for n, axis in enumerate(study.axes):
        if study.asked in [choice.name for choice in axis.choices]:
            return n
    numeric = [n for n, axis in enumerate(study.axes) if axis.is_numeric]
    return numeric[0] if numeric else len(study.axes) - 1


def _groups(study: Study, summaries: Sequence[CellSummary]) -> dict[str, list[_Known]]:
    along, groups = asked_axis(study), dict[str, list[_Known]]()
    for summary in summaries:
        names = [choice.name for choice in summary.cell.choices]
        own = names.pop(along)
        own = own if study.axes[along].is_numeric else _quoted(own)
        known = groups.setdefault(", ".join(names), [])
        if summary.estimate is not None:
            known.append((own, summary.estimate))
    return groups


def _sentence(study: Study, group: str, known: Sequence[_Known]) -> str:
    axis, measure = study.axes[asked_axis(study)], study.measure
    symbol = f"{axis.label.partition(' (')[0]} " if axis.is_numeric else ""
    best = _best(known, measure)
    asked = (study.asked, _quoted(study.asked))
    mark = next((each for each in known if each[0] in asked), best)
    parts = [f"{symbol}{mark[0]} comes to {_shown(mark[1], measure)}"]
    if mark is best:
        parts[0] = f"{symbol}{mark[0]} is {_superlative(measure)}: {_shown(mark[1], measure)}"
    others = [each for each in known if each is not mark]
    parts += _compared(others, mark[1], measure)
    return f"{f'{_capital(group)}: ' if group else ''}{'; '.join(parts)}."


def _compared(others: Sequence[_Known], mark: Estimate, measure: Measure) -> Iterator[str]:
    """What is told apart from the mark, by how much, and what is not."""
    apart = [each for each in others if not overlap(each[1], mark)]
    good = [each for each in apart if _is_better(each[1], mark, measure)]
    names = _words(measure)
    for word, chosen in zip(names, (good, [e for e in apart if e not in good]), strict=True):
        if chosen:
            yield f"{word}: " + ", ".join(f"{n} ({_off(e, mark, measure)})" for n, e in chosen)
    alike = [name for name, estimate in others if overlap(estimate, mark)]
    if alike:
        yield f"within the intervals of it: {', '.join(alike)}"


def _about_blind(study: Study, summaries: Sequence[CellSummary]) -> Iterator[str]:
    """How the best cell stands to an agent that never steers, and which cells are no better."""
    if study.measure is Measure.SUITE:
        yield "An agent that never steers scores 0, one that knows everything 1."
    known = [(s, s.contacts, s.blind) for s in summaries if s.contacts is not None and s.blind]
    if not known or study.measure in (Measure.EDGE_INDEX, Measure.SUITE):
        return
    best, contacts, blind = min(known, key=lambda each: each[1] / (each[2] or 1.0))
    made = _span([each[2] or 0.0 for each in known])
    yield (
        f"An agent that never steers makes {made} contacts per 100 m; of that, "
        f"{_quoted(best.cell.name)} makes {100 * contacts / (blind or 1.0):.0f} %."
    )
    worse = [_quoted(s.cell.name) for s, contacts, blind in known if contacts >= (blind or 0.0)]
    if worse:
        yield f"No better than never steering: {', '.join(worse)}."


def overlap(one: Estimate, other: Estimate) -> bool:
    """Whether two intervals have a point in common."""
    return one.low <= other.high and other.low <= one.high


def _best(known: Sequence[_Known], measure: Measure) -> _Known:
    choose = max if higher_is_better(measure) else min
    return choose(known, key=lambda each: each[1].value)


def _is_better(one: Estimate, other: Estimate, measure: Measure) -> bool:
    return (one.value > other.value) == higher_is_better(measure)


def _superlative(measure: Measure) -> str:
    return "lowest" if measure is Measure.EDGE_INDEX else "best"


def _words(measure: Measure) -> tuple[str, str]:
    return ("lower", "higher") if measure is Measure.EDGE_INDEX else ("better", "worse")


def _off(one: Estimate, mark: Estimate, measure: Measure) -> str:
    """A difference: of scores in their unit, of all else as a share or, from twice on, as times."""
    if measure is Measure.SUITE or mark.value == 0.0:
        return f"by {abs(one.value - mark.value):.{DIGITS[measure]}f}"
    ratio = one.value / mark.value
    return f"{ratio:.1f} times" if ratio >= _TIMES else f"by {abs(100.0 * (ratio - 1.0)):.0f} %"


def _shown(estimate: Estimate, measure: Measure) -> str:
    return f"{interval_words(estimate, DIGITS[measure])} {FIGURE_NAMES[measure]}"


def _span(values: Sequence[float]) -> str:
    low, high = f"{min(values):.1f}", f"{max(values):.1f}"
    return low if low == high else f"{low} to {high}"


def _quoted(name: str) -> str:
    """A name that may have commas in it, for a list."""
    return f"“{name}”"


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
