"""What a comparison of two policies says, as a table and as plain values."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from reflexarc_runtime.words.shown import plain

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.scoring.regression import FamilyVerdict

WORDS = {
    "keeps": "keeps: the loss is below the margin in every family",
    "loses": "loses: the loss is above the margin in a family",
    "undecided": "undecided: neither was shown",
}


def verdict_table(verdicts: "Sequence[FamilyVerdict]", title: str) -> Table:
    """One line a family."""
    table = Table(title=plain(title), title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("family", no_wrap=True)
    for name in ("verdict", "loss", "95 % interval", "smallest found", "looks"):
        table.add_column(name, justify="left" if name == "verdict" else "right")
    for each in verdicts:
        table.add_row(
            plain(each.family),
            str(each.claim),
            f"{each.loss:+.1%}",
            f"{each.low:+.1%} – {each.high:+.1%}",
            f"{each.smallest:.1%}",
            str(each.looks),
        )
    return table


def plain_verdicts(verdicts: "Sequence[FamilyVerdict]", claim: str) -> dict[str, Any]:
    """As plain JSON values."""
    return {"verdict": claim, "families": [asdict(each) for each in verdicts]}
