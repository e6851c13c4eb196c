"""How often `evaluate --against` is wrong, and what it finds: two hundred comparisons, resampled.

    python benchmarks/gate.py runs/reflex-0/policy.onnx [--family outlines body] [--keep FOLDER]

One comparison takes half a minute, two hundred an hour and more. Here a policy drives the ways of
one comparison twice, from other places in the same validation worlds; so does the same policy made
worse (`gate_drives.py`). Every comparison then draws the worlds anew, with replacement, and is
judged by the gate's own code, look after look.

- *alike*: of each world one drive is the new policy and the other the old one, by a toss. Nothing
  but chance tells them apart, so every "loses" is a false alarm. (The very same file from the same
  places differs by nothing at all, and raises none.)
- *worse in FAMILY*: the new policy is the worse one there, in so many worlds that its loss is 15 %,
  and as before in all other families; both from the same places, as the gate drives them. Found is
  what "loses", by that family's name.
"""

import argparse
import json
from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from gate_drives import ALPHA, MARGIN, Driven, drive_all, judged_cells

from reflexarc_sim_bridge.evaluation.driving.paired_drive import (
    FIRST_LOOK_M,
    MOST_M,
    PAIRED_WORLDS,
)
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.scoring.regression import (
    Claim,
    FamilyVerdict,
    Look,
    is_decided,
    judge,
    look_at,
    overall,
)

Worlds = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Found:
    """What the gate said of a policy that is worse in one family."""

    family: str
    contacts: int
    """Of the old policy, in the worlds of one comparison."""
    loss: float
    """Of the worse one where it drives in every world."""
    found: float
    """Share of comparisons in which this family loses."""
    kept: float
    """Share of comparisons in which this family keeps: wrongly."""
    smallest: float
    """Median of the smallest loss that the gate itself says it would have found four times in
    five, of the comparisons with the most looks."""
    way_m: float
    """Mean way of an agent in a comparison."""


def looks_of(new: Floats, old: Floats, families: int) -> list[Look]:
    """The looks of one comparison at a family, until it is decided.

    Args:
        new: contacts of the new policy after each look's way: (looks, worlds).
        old: those of the old one.
        families: how many are judged together.
    """
    looks: list[Look] = []
    for each in zip(new, old, strict=True):
        looks.append(look_at(*each))
        if is_decided(looks, MARGIN, ALPHA, families):
            break
    return looks


def alike(driven: Driven, drawn: Worlds, toss: Worlds) -> tuple[Floats, Floats]:
    """Two drives of one policy in drawn worlds; the toss of a world says which one is the new."""
    return driven.as_it_is[toss, :, drawn].T, driven.as_it_is[1 - toss, :, drawn].T


def worse(
    driven: Driven, drawn: Worlds, toss: Worlds, share: Floats, loss: float
) -> tuple[Floats, Floats]:
    """The worse policy and the one as it is, from the same places in drawn worlds.

    Args:
        driven: of both.
        drawn: worlds.
        toss: from which of the two places.
        share: uniform in [0, 1): below loss ÷ the worse one's loss so far a world has the worse
            one, so that after each look's way just that is lost.
        loss: what is asked for; at most the worse one's.
    """
    old = driven.as_it_is[toss, :, drawn].T
    is_worse = share < loss / np.maximum(loss, driven.losses)[:, np.newaxis]
    return np.where(is_worse, driven.worse[toss, :, drawn].T, old), old


def compare_alike(families: Mapping[str, Driven], seed: int) -> tuple[FamilyVerdict, ...]:
    """One comparison of a policy with itself; world k is drawn in all families or in none."""
    drawn, toss, _ = _draws(families, seed)
    looks = {
        name: looks_of(*alike(driven, drawn, toss), len(families))
        for name, driven in families.items()
    }
    return judge(looks, MARGIN, ALPHA)


def compare_worse(
    families: Mapping[str, Driven],
    family: str,
    loss: float,
    seed: int,
    together: AbstractSet[str] = frozenset(),
) -> FamilyVerdict:
    """What one comparison says of a family in which the new policy is worse, and nowhere else.

    Args:
        families: what was driven.
        family: the one.
        loss: there.
        seed: of the comparison.
        together: names of the families that are judged with it, driven or not.
    """
    drawn, toss, share = _draws(families, seed)
    judged = together | set(families)
    looks = {name: [Look(0.0, 0.0)] for name in judged}
    looks[family] = looks_of(*worse(families[family], drawn, toss, share, loss), len(judged))
    return next(v for v in judge(looks, MARGIN, ALPHA) if v.family == family)


def _draws(families: Mapping[str, Driven], seed: int) -> tuple[Worlds, Worlds, Floats]:
    """Worlds with replacement, a toss and a share for each."""
    n = next(iter(families.values())).as_it_is.shape[-1]
    generator = np.random.default_rng(seed)
    return generator.integers(n, size=n), generator.integers(2, size=n), generator.random(n)


def found_in(
    families: Mapping[str, Driven],
    family: str,
    loss: float,
    comparisons: int,
    together: AbstractSet[str] = frozenset(),
) -> Found | None:
    """What is found of a loss in one family; None if the worse policy did not lose so much."""
    driven = families[family]
    if driven.loss < loss:
        return None
    verdicts = [
        compare_worse(families, family, loss, seed, together) for seed in range(comparisons)
    ]
    most = max(v.looks for v in verdicts)
    return Found(
        family,
        round(float(driven.as_it_is[:, -1].sum() / 2.0)),
        driven.loss,
        sum(v.claim is Claim.LOSES for v in verdicts) / comparisons,
        sum(v.claim is Claim.KEEPS for v in verdicts) / comparisons,
        float(np.median([v.smallest for v in verdicts if v.looks == most])),
        float(np.mean([FIRST_LOOK_M * 2 ** (v.looks - 1) for v in verdicts])),
    )


def main() -> None:
    """Drive, compare and print."""
    given = _arguments()
    families = drive_all(given.policy, given.worlds, given.jobs, given.family, given.keep)
    said = [overall(compare_alike(families, seed)) for seed in range(given.comparisons)]
    together = judged_cells().keys()
    rows = {
        name: found_in(families, name, given.worse, given.comparisons, together)
        for name in families
    }
    if given.json:
        counted = {claim.value: said.count(claim) for claim in Claim}
        found = {name: row and asdict(row) for name, row in rows.items()}
        print(json.dumps({"alike": counted, "worse": given.worse, "families": found}))
        return
    print(f"{given.policy}: {given.worlds} validation worlds, at most {MOST_M:.0f} m in each")
    print(f"\nalike, {given.comparisons} comparisons of {len(families)} families: ", end="")
    print(", ".join(f"{said.count(claim)} {claim}" for claim in Claim))
    print(f"\n{given.worse:.0%} worse in one family, {given.comparisons} comparisons each")
    print("  family        contacts  driven worse   found  undecided   kept  smallest found    way")
    for name, row in rows.items():
        if row is None:
            contacts = round(float(families[name].as_it_is[:, -1].sum() / 2.0))
            print(f"  {name:12} {contacts:9} {families[name].loss:12.1%}   not enough to judge")
            continue
        undecided = 1.0 - row.found - row.kept
        print(
            f"  {name:12} {row.contacts:9} {row.loss:12.1%} {row.found:7.0%} {undecided:10.0%}"
            f" {row.kept:6.0%} {row.smallest:14.1%} {row.way_m:6.0f}"
        )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policy", type=Path)
    parser.add_argument("--comparisons", type=int, default=200)
    parser.add_argument("--worse", type=float, default=0.15)
    parser.add_argument("--worlds", type=int, default=PAIRED_WORLDS)
    parser.add_argument("--family", nargs="*", default=[])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path, help="a folder for what was driven, to go on with")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    main()
