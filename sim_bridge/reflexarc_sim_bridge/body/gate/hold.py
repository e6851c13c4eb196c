"""The button that a person holds to let a body drive (hold-to-run): who holds it, until when.

While the button is down its holder repeats, ten times a second or more, the newest time that it
heard from the body. So it is the body's own clock that says how old a message is, however long it
was on its way, and whatever was recorded, queued or held up is old when it comes. A button counts
for `FRESH_NS` from the time that it repeats.

A press is over once it was released, once it became too old, and at every stop and reset. What
lets a body drive again is a press that began later than that: each message repeats the body's time
of the beginning, too. Whoever comes back from a pause with the button still down moves nothing.

One holds it at a time: what others say meanwhile, also that they let go, changes nothing.
"""

from dataclasses import dataclass

from reflexarc_sim_bridge.body.gate.lease import NOBODY
from reflexarc_sim_bridge.body.gate.refusal import Refusal

FRESH_NS = 500_000_000
"""How long a message lets a body drive, from the time of the body that it repeats."""


@dataclass(frozen=True, slots=True)
class Grip:
    """What somebody says of a button: `reflexarc.HoldToRun`."""

    sender: bytes
    held: bool
    """Whether it is down; or was let go."""
    body: bytes
    source_ns: int
    """The newest time that was heard from the body."""
    pressed_ns: int
    """The time that was heard from the body when the button went down."""


@dataclass(frozen=True, slots=True)
class Button:
    """The button of a body, as the body knows it."""

    by: bytes = NOBODY
    """Who holds it."""
    until_ns: int = 0
    """When it is too old, unless its holder is heard again."""
    ended_ns: int = 0
    """When the last press was over, or forbidden: an earlier one does not count any more."""

    @property
    def is_held(self) -> bool:
        """Whether somebody holds it."""
        return self.by != NOBODY

    def at(self, now_ns: int) -> "Button":
        """The button now: let go, if its holder was not heard for too long."""
        return self.let_go(now_ns) if self.is_held and now_ns >= self.until_ns else self

    def let_go(self, now_ns: int) -> "Button":
        """The button when a press is over, or any would be: at a release, a stop, a reset."""
        return Button(NOBODY, 0, max(now_ns, self.ended_ns))

    def heard(self, grip: Grip, now_ns: int) -> "Button | Refusal":
        """The button after a message to this body; or why that does not count."""
        button = self.at(now_ns)
        if button.is_held and button.by != grip.sender:
            return Refusal.OTHER_HOLDER
        if not grip.held:
            return button.let_go(now_ns) if button.is_held else button
        if max(grip.source_ns, grip.pressed_ns) > now_ns:
            return Refusal.FUTURE
        if now_ns - grip.source_ns >= FRESH_NS:
            return Refusal.OLD
        if grip.pressed_ns < button.ended_ns:
            return Refusal.PRESSED_BEFORE
        until_ns = max(button.until_ns, grip.source_ns + FRESH_NS)
        return Button(grip.sender, until_ns, button.ended_ns)
