"""What the controller is given at a tick, and what it remembers from one tick to the next."""

from dataclasses import dataclass

from reflexarc_runtime.arrays import Memories, Retina
from reflexarc_runtime.backlog import NO_LAG, Lag
from reflexarc_runtime.choice import Hold
from reflexarc_runtime.inertia import Moving
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.sensing.ranges import Ranged
from reflexarc_runtime.sensing.senses import Sensed
from reflexarc_runtime.sensing.stillness import MOVING, Still


@dataclass(frozen=True, slots=True)
class Inputs:
    """What arrived for a tick."""

    messages: tuple[Message, ...]
    """All that arrived since the last tick, oldest first."""
    slot: int
    """Number of the deadline that this tick belongs to."""
    stop: bool = False
    """Under rules 1: the runtime has been asked to end. Since then a stop is a message."""


@dataclass(frozen=True, slots=True)
class BoundBody:
    """The body whose messages count."""

    sender: bytes
    heard_ns: int
    """When it was heard last."""
    stranger_ns: int | None = None
    """When another one was heard last, while this one spoke."""


def bound_after(bound: BoundBody | None, sender: bytes, now_ns: int, silence_ns: int) -> BoundBody:
    """Who counts after a good message: another sender only after this one's silence.

    Args:
        bound: who counted before; None: nobody.
        sender: of the message.
        now_ns: when it came.
        silence_ns: whoever was not heard for longer has gone.
    """
    if bound is None or now_ns - bound.heard_ns > silence_ns:
        return BoundBody(sender, now_ns)
    if bound.sender == sender:
        return BoundBody(sender, now_ns, bound.stranger_ns)
    return BoundBody(bound.sender, bound.heard_ns, now_ns)


@dataclass(frozen=True, slots=True)
class RangeState:
    """What a guard knows of ranges from a topic of their own."""

    newest: Ranged | None = None
    source: BoundBody | None = None
    """The sender whose ranges count; None before the first ones."""
    fault: str = ""
    """Why the newest message cannot be used; empty if it can."""
    backlog: Lag = NO_LAG
    """How far behind the newest ones came."""


NO_RANGES = RangeState()


@dataclass(frozen=True, slots=True)
class Serving:
    """Which of several policies decides; by their hashes."""

    policy_hash: str = ""
    """Empty: the one of the start."""
    former: str = ""
    """Whom a fault brings back; empty: nobody."""
    pending: str = ""
    """Who takes over at the next standstill; empty: nobody."""
    while_moving: bool = False
    """Whether that one need not wait for standstill."""
    answered: bool = False
    """Whether it has decided since it took over, or since its last decision that was ended (before
    rules 5: since the last overrun)."""


SINCE_THE_START = Serving()


@dataclass(frozen=True, slots=True)
class State:
    """What the controller remembers from one tick to the next."""

    index: int = 0
    streak: int = 0
    """Good inputs in a row."""
    newest: Sensed | None = None
    frames: tuple[Retina, ...] = ()
    """The last accepted retinas, oldest first."""
    fault: str = ""
    """Why the newest message cannot be used; empty if it can."""
    memory: Memories | None = None
    """What the policy remembers, (1, size); None: its start value."""
    following: Memories | None = None
    """What it will remember once a newer input is accepted, (1, size)."""
    hold: Hold | None = None
    """The action that is being done; None if the last verdict was not OK."""
    stopped: str = ""
    """Why the robot shall stand until a reset comes; empty if it need not."""
    source: BoundBody | None = None
    """The body whose messages count; None before the first one."""
    overrun: str = ""
    """Why the tick before this one was late; it is forgotten at the end of this one."""
    moving: Moving | None = None
    """How the body is believed to move, where a guard asks; None: not known yet."""
    ranges: RangeState = NO_RANGES
    """What came on the topic of the guard's own ranges, where it has one."""
    backlog: Lag = NO_LAG
    """How far behind the newest input came."""
    still: Still = MOVING
    """For how long the body was told to drive by one picture, where somebody asks."""
    serving: Serving = SINCE_THE_START
    """Who decides, where policies are swapped."""
    drove: bool = False
    """Whether the last command was one to move."""
