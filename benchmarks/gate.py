"""How often `evaluate --against` is wrong, and what it finds: two hundred comparisons, resampled.

    python benchmarks/gate.py runs/reflex-0/policy.onnx [--comparisons 200] [--jobs 2] [--json]

One comparison takes half a minute, two hundred an hour and more. Here a policy drives the ways of
one comparison twice, from other places in the same validation worlds; so does the same policy made
worse: in a share of its decisions, drawn for each family so that it makes some 18 % more contacts,
it sees no difference between its actions. Every comparison then draws the worlds anew, with
replacement, and is judged by the gate's own code, look after look.

- *alike*: of each world one drive is the new policy and the other the old one, by a toss. Nothing
  but chance tells them apart, so every "loses" is a false alarm. (The very same file from the same
  places differs by nothing at all, and raises none.)
- *worse in FAMILY*: the new policy is the worse one there, in so many worlds that its loss is 15 %,
  and as before in all other families; both from the same places, as the gate drives them. Found is
  what "loses", by that family's name.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.paired_drive import (
    FIRST_LOOK_M,
    PAIRED_WORLDS,
    Pair,
    drive_pair,
)
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell, suite_named
from reflexarc_sim_bridge.evaluation.scoring.regression import (
    Claim,
    FamilyVerdict,
    Look,
    is_decided,
    judge,
    look_at,
    overall,
)
from reflexarc_sim_bridge.native.threads import set_thread_count

MARGIN, ALPHA = 0.1, 0.05
"""The gate's own."""
FIRST_SHARE = 0.1
"""Share of decisions that is tried first."""
AIMED_LOSS = 0.18
"""Above the loss that is asked for: mixing worlds makes it exactly that, and not more."""

Worlds = npt.NDArray[np.int64]


class Careless:
    """A policy that in a share of its decisions sees no difference between its actions.

    Args:
        policy: the one that decides otherwise.
        share: of the decisions.
        seed: which ones.
    """

    def __init__(self, policy: Policy, share: float, seed: int) -> None:
        self._policy, self._share = policy, share
        self._generator = np.random.default_rng(seed)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy.decide`."""
        q_values, actions = self._policy.decide(retinas)
        careless = self._generator.random(len(retinas)) < self._share
        return np.where(careless[:, np.newaxis], np.float32(0.0), q_values), np.where(
            careless, 0, actions
        )


@dataclass(frozen=True)
class Driven:
    """Contacts in a family after each look's way, twice from other places: (2, looks, worlds)."""

    as_it_is: Floats
    worse: Floats

    @property
    def loss(self) -> float:
        """Of the worse one, over all the way."""
        return float(self.worse[:, -1].sum() / self.as_it_is[:, -1].sum()) - 1.0


@dataclass(frozen=True)
class Found:
    """What the gate said of a policy that is worse in one family."""

    family: str
    contacts: int
    """Of the old policy, in the worlds of one comparison."""
    found: float
    """Share of comparisons in which this family loses."""
    kept: float
    """Share of comparisons in which this family keeps: wrongly."""
    smallest: float
    """Median of the smallest loss that the gate itself says it would have found four times in
    five."""


def drive_family(path: str, cells: tuple[SuiteCell, ...], worlds: int) -> Driven:
    """What a policy does in a family, and what it does when it is made worse."""
    set_thread_count(1)
    of = contender_of(path)
    tried = _contacts(of, cells, FIRST_SHARE, worlds, lane=2, looks=1)
    loss = max(tried[1].sum() / tried[0].sum() - 1.0, 0.02)
    share = min(1.0, FIRST_SHARE * AIMED_LOSS / loss)
    twice = [_contacts(of, cells, share, worlds, lane) for lane in (0, 1)]
    return Driven(*np.swapaxes(np.array(twice), 0, 1))


def _contacts(
    of: Contender,
    cells: tuple[SuiteCell, ...],
    share: float,
    worlds: int,
    lane: int,
    looks: int = 4,
) -> Floats:
    """Of the policy and of a careless one: (2, looks, worlds)."""
    careless = replace(of, policy=Careless(of.policy, share, lane))  # type: ignore[arg-type]
    found: list[list[Floats]] = []

    def is_enough(pair: Pair) -> bool:
        found.append([pair.old.copy(), pair.new.copy()])
        return len(found) == looks

    drive_pair(careless, of, cells, Setting.FIELD, is_enough, worlds, lane)
    return np.swapaxes(np.array(found), 0, 1)


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
        share: uniform in [0, 1): below loss ÷ the worse one's loss a world has the worse one.
        loss: what is asked for; at most the worse one's.
    """
    old = driven.as_it_is[toss, :, drawn].T
    is_worse = share < loss / driven.loss
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
    families: Mapping[str, Driven], family: str, loss: float, seed: int
) -> FamilyVerdict:
    """What one comparison says of a family in which the new policy is worse, and nowhere else."""
    drawn, toss, share = _draws(families, seed)
    nothing = [Look(0.0, 0.0)]
    looks = dict.fromkeys(families, nothing)
    looks[family] = looks_of(*worse(families[family], drawn, toss, share, loss), len(families))
    return next(v for v in judge(looks, MARGIN, ALPHA) if v.family == family)


def _draws(families: Mapping[str, Driven], seed: int) -> tuple[Worlds, Worlds, Floats]:
    """Worlds with replacement, a toss and a share for each."""
    n = next(iter(families.values())).as_it_is.shape[-1]
    generator = np.random.default_rng(seed)
    return generator.integers(n, size=n), generator.integers(2, size=n), generator.random(n)


def found_in(
    families: Mapping[str, Driven], family: str, loss: float, comparisons: int
) -> Found | None:
    """What is found of a loss in one family; None if the worse policy did not lose so much."""
    driven = families[family]
    if driven.loss < loss:
        return None
    verdicts = [compare_worse(families, family, loss, seed) for seed in range(comparisons)]
    last = [v for v in verdicts if v.looks == len(driven.as_it_is[0])]
    return Found(
        family,
        round(float(driven.as_it_is[:, -1].sum() / 2.0)),
        sum(v.claim is Claim.LOSES for v in verdicts) / comparisons,
        sum(v.claim is Claim.KEEPS for v in verdicts) / comparisons,
        float(np.median([v.smallest for v in last or verdicts])),
    )


def drive_all(path: str, worlds: int, jobs: int, only: Sequence[str]) -> dict[str, Driven]:
    """Every family of `lite`, the longest first."""
    suite = suite_named("lite").only(tuple(only)) if only else suite_named("lite")
    cells = {
        family.name: tuple(cell for cell in family.cells if cell.counts)
        for family in suite.families
    }
    cells = dict(sorted(cells.items(), key=lambda item: -len(item[1])))
    cells = {name: each for name, each in cells.items() if each}
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        n = len(cells)
        driven = list(pool.map(drive_family, [path] * n, cells.values(), [worlds] * n))
    return dict(zip(cells, driven, strict=True))


def main() -> None:
    """Drive, compare and print."""
    given = _arguments()
    families = drive_all(str(given.policy), given.worlds, given.jobs, given.family)
    said = [overall(compare_alike(families, seed)) for seed in range(given.comparisons)]
    rows = {name: found_in(families, name, given.worse, given.comparisons) for name in families}
    if given.json:
        counted = {claim.value: said.count(claim) for claim in Claim}
        found = {name: row and asdict(row) for name, row in rows.items()}
        print(json.dumps({"alike": counted, "worse": given.worse, "families": found}))
        return
    metres = FIRST_LOOK_M * 8
    print(f"{given.policy}: {given.worlds} validation worlds, at most {metres:.0f} m in each")
    print(f"\nalike, {given.comparisons} comparisons of {len(families)} families: ", end="")
    print(", ".join(f"{said.count(claim)} {claim}" for claim in Claim))
    print(f"\n{given.worse:.0%} worse in one family, {given.comparisons} comparisons each")
    print("  family        contacts   found  undecided   kept  smallest found")
    for name, row in rows.items():
        if row is None:
            print(f"  {name:12} {'made worse by':>20} {families[name].loss:.0%} only")
            continue
        undecided = 1.0 - row.found - row.kept
        print(
            f"  {name:12} {row.contacts:9} {row.found:7.0%} {undecided:10.0%} {row.kept:6.0%}"
            f" {row.smallest:14.1%}"
        )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policy", type=Path)
    parser.add_argument("--comparisons", type=int, default=200)
    parser.add_argument("--worse", type=float, default=0.15)
    parser.add_argument("--worlds", type=int, default=PAIRED_WORLDS)
    parser.add_argument("--family", nargs="*", default=[])
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    main()
