"""The guard of a robot, for many simulated agents at once, and what it did.

A simulation moves its agents by actions out of a table, so each action stands in it once for every
share of its speed that a guard may leave, and standstill is its last row.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.guard import SHARES, Guard, answers
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.sensing.distances import beams_of_retina, check_tells_ranges

MOST_ACTIONS = 15
"""With their shares and standstill they fill what a contract may hold."""


@dataclass
class Interventions:
    """What the guard did, in decisions of single agents."""

    decisions: int = 0
    guarded: int = 0
    """Another action than the policy's, or a slower motion."""
    stuck: int = 0
    """Standstill."""


class CrowdGuard:
    """Guards the actions of many agents.

    Args:
        settings: as a robot's.
        contract: of the policy that drives them.
        period_s: time between two decisions; a command holds no shorter.
        age_s: how old a look is when a command is obeyed.

    Raises:
        ContractError: their retinas tell no distance.
        WorldError: more actions than a guarded simulation has room for.
    """

    def __init__(
        self, settings: GuardSettings, contract: PolicyContract, period_s: float, age_s: float = 0.0
    ) -> None:
        check_tells_ranges(contract.retina)
        if len(contract.actions) > MOST_ACTIONS:
            got = len(contract.actions)
            raise WorldError(f"guard: expected at most {MOST_ACTIONS} actions, got {got}")
        valid_for_s = max(contract.max_input_age_s, period_s)
        self._guard = Guard(settings, contract.actions, valid_for_s)
        self._contract = contract
        self._age_s = age_s
        self._period_s = period_s
        self._moving: npt.NDArray[np.float64] | None = None
        """How each agent is believed to move, (agents, 3), as a robot's controller believes."""
        self._speeds = np.array(
            [(a.linear_mps, a.lateral_mps, a.angular_radps) for a in self.contract.actions]
        )
        self.did = Interventions()

    @property
    def contract(self) -> PolicyContract:
        """What the simulation moves by."""
        return slowed(self._contract)

    def act(self, stacks: RetinaBatch, wanted: Actions, q_values: QValues) -> Actions:
        """Rows of the table of motions, (agents,), by what the agents see and want."""
        beams = beams_of_retina(stacks[:, -1], self._contract.retina)
        if self._moving is None:
            self._moving = np.zeros((len(wanted), 3))
        actions, shares = answers(self._guard, wanted, q_values, beams, self._age_s, self._moving)
        rows = _rows(actions, shares, len(self._contract.actions))
        self._moving = self._later(self._moving, self._speeds[rows])
        self.did.decisions += len(rows)
        self.did.stuck += int((shares == 0.0).sum())
        self.did.guarded += int(((rows != wanted) & (shares > 0.0)).sum())
        return rows

    def _later(
        self, moving: npt.NDArray[np.float64], told: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.float64]:
        """`followed`, for all agents."""
        braking = self._guard.settings.follows_mps2
        most_mps = math.inf if braking is None else braking * self._period_s
        later = moving + np.clip(told - moving, -most_mps, most_mps)
        later[:, 2] = told[:, 2]
        return later


def slowed(contract: PolicyContract) -> PolicyContract:
    """The contract with each action at each share of its speed, and standstill as the last one."""
    actions = [_scaled(action, share) for share in SHARES for action in contract.actions]
    stand = Action("stand still", 0.0, 0.0)
    return replace(contract, actions=(*actions, stand), golden=GoldenVectors())


def _scaled(action: Action, share: float) -> Action:
    return Action(
        f"{action.name} at {share:.0%}",
        share * action.linear_mps,
        share * action.lateral_mps,
        share * action.angular_radps,
    )


def _rows(actions: Actions, shares: npt.NDArray[np.float64], count: int) -> Actions:
    """Where in the table each action at its share stands: the shares fall by equal steps."""
    level = np.rint((1.0 - shares) * len(SHARES)).astype(np.int64)
    return np.where(shares > 0.0, level * count + actions, len(SHARES) * count)
