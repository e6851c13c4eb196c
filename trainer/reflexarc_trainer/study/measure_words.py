"""How the measures of a study are written: their names, their digits, which way is better."""

from reflexarc_sim_bridge.evaluation.scoring.statistics import Estimate
from reflexarc_trainer.study.unit import Measure

FIGURE_NAMES = {
    Measure.CONTACTS: "contacts per 100 m",
    Measure.SHARE_OF_BLIND: "share of the blind agent's contacts",
    Measure.EDGE_INDEX: "edge index",
    Measure.SUITE: "score in the lite suite",
}
"""Name of each measure in tables and figures."""

DIGITS = {
    Measure.CONTACTS: 2,
    Measure.SHARE_OF_BLIND: 3,
    Measure.EDGE_INDEX: 2,
    Measure.SUITE: 3,
}


def higher_is_better(measure: Measure) -> bool:
    """Whether more of it is better."""
    return measure is Measure.SUITE


def interval_words(estimate: Estimate, digits: int) -> str:
    """An estimate with its interval: "2.00 [1.90, 2.10]"."""
    return f"{estimate.value:.{digits}f} [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]"
