"""Lockstep as a body sees it: after each sensor message it waits for the command.

In lockstep the runtime makes one tick for each input, and numbers its commands from 0, as the body
numbers its sensor messages; so the command of message n is command n. The runtime's side is
`pacing.lockstep_pacer`.
"""

from collections.abc import Callable

from reflexarc_runtime.errors import BusError
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.wire import Message

PATIENCE_S = 10.0
"""How long a body waits for the command of a sensor message before it gives up."""

_POLL_S = 0.05


def wait_for_runtime(
    inbox: Inbox, is_ready: Callable[[], bool], should_stop: Callable[[], bool]
) -> None:
    """Wait until a runtime listens and has announced itself; commands before that are dropped.

    Args:
        inbox: where the bus delivers the commands.
        is_ready: whether the runtime listens to the sensor and has announced itself.
        should_stop: whether to wait no longer.
    """
    while not is_ready() and not should_stop():
        inbox.take(_POLL_S)


def await_command(
    inbox: Inbox,
    sequence: int,
    hear: Callable[[Message], None],
    should_stop: Callable[[], bool],
) -> None:
    """Wait for the command of a sensor message.

    Args:
        inbox: where the bus delivers the commands.
        sequence: number of the sensor message.
        hear: called with every message that comes, up to the command that is waited for.
        should_stop: whether to wait no longer.

    Raises:
        BusError: it did not come within `PATIENCE_S`.
    """
    waited_s = 0.0
    while not should_stop():
        message = inbox.take(_POLL_S)
        if message is None:
            waited_s += _POLL_S
        else:
            hear(message)
            command = decode_command(message.payload)
            if command is not None and command.sequence == sequence:
                return
        if waited_s > PATIENCE_S:
            raise BusError(
                f"lockstep: no command for sensor message {sequence} within {PATIENCE_S:g} s; "
                "is `reflexarc run --lockstep` still there, and newly started?"
            )
