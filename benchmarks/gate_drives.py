"""What a policy does on the ways of one comparison, and what a careless copy of it does.

A careless copy sees, in a share of its decisions, no difference between its actions. The share is
tried out for each family, on other ways, until the copy makes about a fifth more contacts there. A
share that is only guessed may make four times as many: then a loss of 15 % is one in a few worlds
of many, and of another kind than what is asked for.
"""

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.paired_drive import Pair, drive_pair
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell, suite_named
from reflexarc_sim_bridge.evaluation.scoring.regression import Look, is_last, look_at
from reflexarc_sim_bridge.native.threads import set_thread_count

MARGIN, ALPHA = 0.1, 0.05
"""The gate's own."""
FIRST_SHARE = 0.1
"""Share of decisions that is tried first."""
AIMED_LOSS = 0.2
"""Above the loss that is asked for: mixing worlds makes it exactly that, and not more."""
NEAR_ENOUGH = (0.18, 0.225)
"""Losses between these are taken as they are."""
TRIES = 8
TRIED_ERROR = 0.025
"""Of a loss that is tried."""
ROOM = 0.9
"""Of the error at which the gate looks no more: worlds that are drawn anew have a larger one."""


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
    """Contacts in a family after each look's way, twice from other places: (2, looks, worlds).

    As many looks as the gate would take, and not more.
    """

    as_it_is: Floats
    worse: Floats

    @property
    def losses(self) -> Floats:
        """Of the worse one, after each look's way: (looks,)."""
        old = np.maximum(1.0, self.as_it_is.sum(axis=(0, 2)))
        losses: Floats = self.worse.sum(axis=(0, 2)) / old - 1.0
        return losses

    @property
    def loss(self) -> float:
        """Of the worse one, over all the way."""
        return float(self.worse[:, -1].sum()) / max(1.0, float(self.as_it_is[:, -1].sum())) - 1.0


def judged_cells() -> dict[str, tuple[SuiteCell, ...]]:
    """Of every family of `lite` those that count, the longest family first."""
    families = suite_named("lite").families
    cells = {each.name: tuple(cell for cell in each.cells if cell.counts) for each in families}
    longest_first = sorted(cells.items(), key=lambda item: -len(item[1]))
    return {name: each for name, each in longest_first if each}


def drive_all(
    path: Path, worlds: int, jobs: int, only: Sequence[str], kept: Path | None = None
) -> dict[str, Driven]:
    """Every family, or some.

    Args:
        path: of the policy.
        worlds: how many validation worlds.
        jobs: processes.
        only: names of families; none: all.
        kept: a folder of what this policy did before, with this code: what is there is not driven
            again, and what is not is put there.
    """
    cells = {name: each for name, each in judged_cells().items() if name in only or not only}
    policy = hashlib.sha256(path.read_bytes()).hexdigest()[:12]
    files = [kept and kept / f"{policy}-{worlds}-{name}.npz" for name in cells]
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        n = len(cells)
        drives = pool.map(driven_before, [str(path)] * n, cells.values(), [worlds] * n, files)
        return dict(zip(cells, drives, strict=True))


def driven_before(
    path: str, cells: tuple[SuiteCell, ...], worlds: int, kept: Path | None
) -> Driven:
    """A family from its file, or driven and put there."""
    if kept is not None and kept.exists():
        with np.load(kept) as sums:
            return Driven(sums["as_it_is"], sums["worse"])
    driven = drive_family(path, cells, worlds)
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez(kept, as_it_is=driven.as_it_is, worse=driven.worse)
    return driven


def drive_family(path: str, cells: tuple[SuiteCell, ...], worlds: int) -> Driven:
    """What a policy does in a family, and what it does when it is made worse."""
    set_thread_count(1)
    of = contender_of(path)

    def loss_of(share: float) -> float:
        tried = _contacts(of, cells, share, worlds, 2, lambda looks: looks[-1].error < TRIED_ERROR)
        old, new = tried[:, -1].sum(axis=-1)
        return float(new) / max(1.0, float(old)) - 1.0

    share = share_for(loss_of)
    first = _contacts(of, cells, share, worlds, 0, is_far_enough)
    other = _contacts(of, cells, share, worlds, 1, lambda looks: len(looks) == first.shape[1])
    return Driven(*np.swapaxes(np.array([first, other]), 0, 1))


def is_far_enough(looks: Sequence[Look]) -> bool:
    """Whether the gate would not look again, in other draws of these worlds either."""
    roomy = [replace(look, error=look.error / ROOM) for look in looks]
    return is_last(roomy, MARGIN, ALPHA, len(judged_cells()))


def share_for(loss_of: Callable[[float], float]) -> float:
    """The share of decisions at which a copy loses about `AIMED_LOSS`; 1 where none is enough.

    Args:
        loss_of: what a copy loses at a share, tried out.
    """
    known, share = {0.0: 0.0}, FIRST_SHARE
    for _ in range(TRIES):
        known[share] = loss_of(share)
        if NEAR_ENOUGH[0] <= known[share] <= NEAR_ENOUGH[1]:
            break
        share = _next_share(known)
        if share in known:
            break
    return share


def _next_share(known: Mapping[float, float]) -> float:
    """Between the shares that lost too little and too much; else twice the most, and never more.

    What hardly loses anything at a tenth may lose many times as much at a half; on such a curve a
    straight line alone always stays too low, so that it is taken halfway to the middle.
    """
    too_much = [share for share, loss in known.items() if loss > AIMED_LOSS]
    if not too_much:
        return min(1.0, 2.0 * max(known))
    above = min(too_much)
    below = max(share for share in known if share < above)
    part = (AIMED_LOSS - known[below]) / (known[above] - known[below])
    return below + (0.5 * part + 0.25) * (above - below)


def _contacts(
    of: Contender,
    cells: tuple[SuiteCell, ...],
    share: float,
    worlds: int,
    lane: int,
    is_enough: Callable[[Sequence[Look]], bool],
) -> Floats:
    """Of the policy and of a careless one, until it is enough: (2, looks, worlds)."""
    careless = replace(of, policy=Careless(of.policy, share, lane))  # type: ignore[arg-type]
    found: list[list[Floats]] = []
    looks: list[Look] = []

    def look(pair: Pair) -> bool:
        found.append([pair.old.copy(), pair.new.copy()])
        looks.append(unpaired(look_at(pair.new, pair.old), pair))
        return is_enough(looks)

    drive_pair(careless, of, cells, Setting.FIELD, look, worlds, lane)
    return np.swapaxes(np.array(found), 0, 1)


def unpaired(look: Look, pair: Pair) -> Look:
    """With the error of two independent counts, if that is larger: two drives that are *alike*
    start from different places.
    """
    counts = (1.0 + float(pair.new.sum()), 1.0 + float(pair.old.sum()))
    return replace(look, error=max(look.error, math.sqrt(1.0 / counts[0] + 1.0 / counts[1])))
