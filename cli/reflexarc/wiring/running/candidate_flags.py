"""The flags of policies beside the one that a run begins with: who may take over, who watches."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.loop.candidates.shadow import Shadow
    from reflexarc_runtime.messages.wire import Message

NOT_ALLOWED = "this runtime takes no other policy: start it with --allow-swap"
NOT_IN_LOCKSTEP = "a runtime in lockstep takes no other policy: its runs are to be the same"


@dataclass(frozen=True)
class WatchingPolicy:
    """A policy that watches, from a file that was tried."""

    path: Path
    """What errors call it; it is not read again."""
    policy_hash: str
    data: bytes
    backend: str

    def shadow(self, bus: "Bus", put: "Callable[[Message], None]", *, lockstep: bool) -> "Shadow":
        """Its shadow of one loop."""
        from reflexarc_runtime.loop.candidates.shadow import Shadow
        from reflexarc_runtime.messages.topics import SHADOW

        return Shadow(
            self.data,
            self.backend,
            put,
            bus.publisher(SHADOW),
            name=str(self.path),
            robot=bus.robot,
            sender=bus.sender,
            patience_s=LOCKSTEP_PATIENCE_S * lockstep,
        )


LOCKSTEP_PATIENCE_S = 5.0
"""How long lockstep waits for a shadow: no time passes meanwhile."""


@dataclass(frozen=True)
class CandidateFlags:
    """Who may decide later, and who would have decided otherwise."""

    allow_swap: bool = False
    """Let `reflexarc swap` change the policy of the running loop: whoever reaches the bus can."""
    shadow: Path | None = None
    """A policy (ONNX) that watches without acting: where it would have done something else is
    counted and recorded."""

    def why_no_swap(self, *, lockstep: bool) -> str:
        """Why no policy may take over, in words; empty if one may."""
        if lockstep:
            return NOT_IN_LOCKSTEP
        return "" if self.allow_swap else NOT_ALLOWED

    def watcher(
        self, running: "PolicyContract", backend: str, accepted: bytes | None = None
    ) -> WatchingPolicy | None:
        """The policy that watches, after a process of its own has tried it; None: there is none.

        Args:
            running: the contract of the policy that drives.
            backend: what computes it.
            accepted: the bytes of its file that somebody vouched for; None: nobody need.

        Raises:
            PolicyError, ContractError: it is not intact, or not of the running contract.
        """
        if self.shadow is None:
            return None
        from reflexarc_runtime.contract.swap_fit import check_takes_over
        from reflexarc_runtime.loop.candidates.trial_helper import TrialHere
        from reflexarc_runtime.loop.trials.tried_policy import finding_of
        from reflexarc_runtime.policy.model_file import read_model
        from reflexarc_runtime.policy.policy import load_contract

        data, tries = accepted or read_model(self.shadow), TrialHere()
        finding = finding_of(data, str(self.shadow), lambda path: tries.finding(path, backend))
        check_takes_over(load_contract(data, bounds=None), running)
        return WatchingPolicy(self.shadow, finding.policy_hash, data, backend)


def others_of(watcher: WatchingPolicy | None) -> dict[str, bytes]:
    """What a log holds of it, by its hash."""
    return {} if watcher is None else {watcher.policy_hash: watcher.data}


def watching(
    watcher: WatchingPolicy | None, bus: "Bus", put: "Callable[[Message], None]", *, lockstep: bool
) -> "AbstractContextManager[Shadow | None]":
    """The shadow of a loop inside this context; None if there is none."""
    return nullcontext() if watcher is None else watcher.shadow(bus, put, lockstep=lockstep)
