"""What a policy does on the ways of one comparison, and what a careless copy of it does.

A careless copy sees, in a share of its decisions, no difference between its actions. The share is
tried out for each family, so that it may make about a fifth more contacts there.
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.paired_drive import Pair, drive_pair
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell, suite_named
from reflexarc_sim_bridge.native.threads import set_thread_count

FIRST_SHARE = 0.1
"""Share of decisions that is tried first."""
AIMED_LOSS = 0.18
"""Above the loss that is asked for: mixing worlds makes it exactly that, and not more."""
LEAST_LOSS = 0.02
"""What chance makes of few contacts does not lead astray."""


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
        return float(self.worse[:, -1].sum()) / max(1.0, float(self.as_it_is[:, -1].sum())) - 1.0


def judged_cells() -> dict[str, tuple[SuiteCell, ...]]:
    """Of every family of `lite` those that count, the longest family first."""
    families = suite_named("lite").families
    cells = {each.name: tuple(cell for cell in each.cells if cell.counts) for each in families}
    longest_first = sorted(cells.items(), key=lambda item: -len(item[1]))
    return {name: each for name, each in longest_first if each}


def drive_all(path: str, worlds: int, jobs: int, only: Sequence[str]) -> dict[str, Driven]:
    """Every family, or some."""
    cells = {name: each for name, each in judged_cells().items() if name in only or not only}
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
        n = len(cells)
        driven = list(pool.map(drive_family, [path] * n, cells.values(), [worlds] * n))
    return dict(zip(cells, driven, strict=True))


def drive_family(path: str, cells: tuple[SuiteCell, ...], worlds: int) -> Driven:
    """What a policy does in a family, and what it does when it is made worse."""
    set_thread_count(1)
    of = contender_of(path)
    tried = _contacts(of, cells, FIRST_SHARE, worlds, lane=2, looks=1)
    loss = float(tried[1].sum()) / max(1.0, float(tried[0].sum())) - 1.0
    share = min(1.0, FIRST_SHARE * AIMED_LOSS / max(loss, LEAST_LOSS))
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
