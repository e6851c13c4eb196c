"""What a body decides for itself, from its own configuration."""

from dataclasses import dataclass, field
from functools import cached_property

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion


@dataclass(frozen=True)
class GateSettings:
    """What a body decides for itself."""

    max_input_age_s: float
    """Silence after which the holder loses the lease, seconds."""
    limits: BodyLimits = field(default_factory=BodyLimits)
    """What the body does at most."""
    auto_arm: bool = False
    """Whether it is armed at its start and after a reset, without being asked."""
    hold_to_run: bool = False
    """Whether only a held button arms it: see `hold.py`."""
    arm_each_runtime: bool = False
    """Whether an arm counts for one runtime: the next one that gets the lease is armed anew."""
    lockstep: bool = False
    """Whether time is counted in steps: then no lease expires."""
    safe: Motion = STANDSTILL
    """What it does when it is armed and there is nothing to obey."""

    def __post_init__(self) -> None:
        if not 0.0 < self.max_input_age_s < 1e9:
            raise UsageError(
                f"max_input_age_s: expected above 0 and finite, got {self.max_input_age_s}"
            )
        if self.auto_arm and self.hold_to_run:
            raise UsageError(
                "expected a body that arms itself or one that needs a button, got both"
            )
        if self.auto_arm and self.arm_each_runtime:
            raise UsageError(
                "expected a body that arms itself or one that is armed for each runtime, got both"
            )
        if self.lockstep and self.hold_to_run:
            raise UsageError("expected real time for a button that is held, got lockstep")

    @cached_property
    def silence_ns(self) -> int | None:
        """The longest silence of a holder; None: nothing expires."""
        return None if self.lockstep else round(self.max_input_age_s * 1e9)

    @cached_property
    def valid_for_ns(self) -> int:
        """The body's own longest validity of a command."""
        return self.limits.valid_for_ns
