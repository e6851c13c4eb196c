"""What a watchdog says in the place of a loop that is late: stand, and why.

It has outlets of its own, with numbers of their own: the loop's publishers are the loop's.
"""

from collections.abc import Callable
from dataclasses import dataclass

from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Verdict, safe_command
from reflexarc_runtime.loop.outlets import Outlet
from reflexarc_runtime.messages.codec import Status, encode_command, encode_status
from reflexarc_runtime.messages.controls import encode_overrun
from reflexarc_runtime.messages.topics import OVERRUN, RUNTIME_NODE
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding


@dataclass(frozen=True)
class OwnOutlets:
    """The topics on which a stand-in publishes."""

    command: Outlet
    overrun: Outlet
    status: Outlet


class StandIn:
    """Speaks in the place of one loop.

    Args:
        outlets: where it speaks.
        safe: the contract's safe command.
        robot: the robot's name.
        sender: the identifier of the loop, which is its own as well.
        run_id: of the loop's run.
        policy_hash: of the policy that serves.
    """

    def __init__(
        self,
        outlets: OwnOutlets,
        safe: Action,
        *,
        robot: str,
        sender: bytes,
        run_id: str = "",
        policy_hash: Callable[[], str] = lambda: "",
    ) -> None:
        self._outlets = outlets
        self._safe = safe
        self._key = OVERRUN.key(robot)
        self._sender = sender
        self._run_id = run_id
        self._policy_hash = policy_hash
        self._commands = 0
        self._overruns = 0

    def stand(self, now_ns: int) -> None:
        """Send the safe command."""
        command = safe_command(self._commands, Verdict.OVERRUN, self._safe)
        self._outlets.command.put(encode_command(command), now_ns)
        self._commands += 1

    def tell(self, since_ns: int, late_ns: int, now_ns: int) -> Message:
        """Say how late the loop is; the message that its inbox is given."""
        payload = encode_overrun(since_ns, late_ns)
        self._outlets.overrun.put(payload, now_ns)
        self._outlets.status.put(encode_status(self._status(late_ns)), now_ns)
        stamp = pack_stamp(Stamp(self._overruns, now_ns, self._sender))
        self._overruns += 1
        return Message(self._key, payload, protobuf_encoding(OVERRUN.schema), stamp, now_ns)

    def _status(self, late_ns: int) -> Status:
        return Status(
            node=RUNTIME_NODE,
            run_id=self._run_id,
            policy_hash=self._policy_hash(),
            verdicts=((Verdict.OVERRUN.name, self._overruns + 1),),
            verdict=int(Verdict.OVERRUN),
            is_stand_in=True,
            watchdog=f"the loop is late: {late_ns / 1e6:.0f} ms",
        )
