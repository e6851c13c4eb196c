"""The policy contract: the only definition of what a policy sees and does.

The trainer builds its world's eye from it, the exporter writes it into the ONNX file, the body
builds its senses from it, the runtime checks every message against it, the log carries it.

Frames and signs: x ahead, y to the left, bearings counter-clockwise with 0 ahead. Index 0 of a
retina is the leftmost ray. SI units; times on the bus are integer nanoseconds.
"""

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Self

from reflexarc_runtime.choice import slots_of
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.golden import GoldenVectors, check_golden
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.contract.text import SEALED_SINCE, open_text, seal
from reflexarc_runtime.errors import ContractError

METADATA_KEY = "reflexarc.contract"

_require = partial(require, error=ContractError)


@dataclass(frozen=True)
class PolicyContract:
    """What a policy sees, what it does, how fast, and how to know that it is intact."""

    retina: RetinaSpec = field(default_factory=RetinaSpec)
    actions: tuple[Action, ...] = field(default_factory=sideways_actions)
    safe_command: Action = field(default_factory=lambda: Action("stop", 0.0, 0.0))
    """Sent whenever the verdict is not OK."""
    rate_hz: float = 50.0
    """Rate of the sense–act loop."""
    max_input_age_s: float = 0.1
    """An input older than this is stale."""
    body: BodySpec = field(default_factory=BodySpec)
    """The body that it learned with."""
    recovery_inputs: int = 3
    """Good inputs in a row before it may drive, at the start and after every fault."""
    hold_s: float = 0.0
    """An action is done for at least so long, rounded up to ticks; any verdict but OK ends it."""
    margin: float = 0.0
    """Another action is taken only if it wins by this share of the spread of the Q-values (largest
    minus smallest) over the one that is being done, in [0, 1]."""
    least_lead: float = 0.0
    """Nor is it taken unless its Q-value is larger by this, in the unit of the Q-values."""
    q_tolerance: float = 1e-6
    """What the Q-values of two backends may differ by, times the larger of 1 and |Q|."""
    state: StateSpec = field(default_factory=StateSpec)
    """Its memory, if it has one."""
    goal: bool = False
    """Whether the graph has an input `goal`, float32 [N, 2]: bearing (rad) and distance (m) of the
    place to go to. Reserved: no runtime feeds it yet."""
    provenance: Provenance = field(default_factory=Provenance)
    golden: GoldenVectors = field(default_factory=GoldenVectors)

    def __post_init__(self) -> None:
        _require(2 <= len(self.actions) <= 64, "actions", "2 to 64", len(self.actions))
        names = [action.name for action in self.actions]
        _require(len(set(names)) == len(names), "actions", "distinct names", names)
        _require(0.1 <= self.rate_hz <= 10_000.0, "rate_hz", "0.1 to 10000", self.rate_hz)
        age_s, most = self.max_input_age_s, self.recovery_inputs
        _require(0.0 < age_s <= 3600.0, "max_input_age_s", "in (0, 3600]", age_s)
        _require(1 <= most <= 1000, "recovery_inputs", "1 to 1000", most)
        _require(0.0 <= self.hold_s <= 3600.0, "hold_s", "in [0, 3600]", self.hold_s)
        _require(0.0 <= self.margin <= 1.0, "margin", "in [0, 1]", self.margin)
        lead = self.least_lead
        _require(0.0 <= lead < math.inf, "least_lead", "0 or more, and finite", lead)
        _require(0.0 < self.q_tolerance <= 1.0, "q_tolerance", "in (0, 1]", self.q_tolerance)
        values = self.retina.frames * self.retina.size
        check_golden(self.golden, values, len(self.actions), self.state.size)

    @cached_property
    def max_input_age_ns(self) -> int:
        """`max_input_age_s` in nanoseconds."""
        return round(self.max_input_age_s * 1e9)

    @cached_property
    def hold_slots(self) -> int:
        """`hold_s` in periods of the loop, rounded up."""
        return slots_of(self.hold_s, self.rate_hz)

    @property
    def keeps_actions(self) -> bool:
        """Whether another action than the winner may be done: one that is held, or hardly worse."""
        return self.hold_slots > 0 or self.margin > 0.0 or self.least_lead > 0.0

    def to_json(self) -> str:
        """The contract as text: canonical JSON with its schema version, sealed with a digest."""
        return seal(dataclasses.asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read a contract back, of this schema or an older one.

        Raises:
            ContractError: not JSON, a schema newer than this package, a digest that does not fit,
                or a field that is missing, unknown, of the wrong type or out of range.
        """
        document, _ = open_text(text)
        return fill(cls, MappingSource(document, "contract", ContractError), require_all=True)


def why_unsealed(text: str) -> str:
    """What to know about a contract without a digest; empty for one that has it.

    Raises:
        ContractError: see `PolicyContract.from_json`.
    """
    _, schema = open_text(text)
    if schema >= SEALED_SINCE:
        return ""
    return (
        f"its contract is of schema {schema}, which has no digest: a speed that was changed by "
        "accident would not be noticed; export the policy again"
    )
