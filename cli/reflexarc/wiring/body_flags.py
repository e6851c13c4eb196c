"""The flags by which a robot's owner says what its body is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc.wiring.bus_flags import contract_of
from reflexarc_runtime.contract.body_fit import check_body

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.contract.body_spec import BodySpec


@dataclass(frozen=True)
class BodyFlags:
    """The robot's body. Where it is told, a policy for a smaller or quicker one is refused."""

    radius: float | None = None
    """From the point about which it turns to its farthest corner, metres."""
    deceleration: float | None = None
    """How hard it brakes, m/s²."""
    delay: float | None = None
    """Seconds after which it obeys."""
    allow_body: bool = False
    """Let a policy drive that learned with a smaller, quicker or prompter body."""

    def check_runtime(self, bus: "Bus", stop: Callable[[], bool], who: str) -> None:
        """Wait for a runtime, where a body is told, and refuse a policy that does not fit it.

        Raises:
            ContractError: in what the body is worse than the one that the policy learned with.
        """
        if self.allow_body or self.radius is self.deceleration is self.delay is None:
            return
        true = self._body()
        contract = contract_of(None, bus, stop, who, None)
        if contract is not None:
            check_body(contract.body, true)

    def _body(self) -> "BodySpec":
        from reflexarc_runtime.contract.body_spec import BodySpec, Footprint

        outline = Footprint(radius_m=self.radius or 0.0)
        return BodySpec(outline, self.delay or 0.0, self.deceleration)
