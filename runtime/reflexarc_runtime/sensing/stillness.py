"""A picture that never changes while the body drives: its driver hangs.

Noise alone changes a scan from one to the next, and a drive changes what is seen. Whoever stands
still before a simulated wall sees the same for ever, so only the time counts during which the body
was told to drive.
"""

from dataclasses import dataclass, replace
from hashlib import blake2b

_DIGEST_BYTES = 8


@dataclass(frozen=True, slots=True)
class Still:
    """For how long a body was told to drive by one and the same picture."""

    picture: bytes = b""
    """What it looks like, in a few bytes."""
    driven_ns: int = 0
    """How long the body was told to drive by it."""
    told_ns: int | None = None
    """The last tick, if the body was told to drive at it."""

    def seen(self, picture: bytes) -> "Still":
        """After another picture of the sensor."""
        return self if picture == self.picture else Still(picture, told_ns=self.told_ns)

    def told(self, drives: bool, now_ns: int) -> "Still":
        """After a tick, at which the body was told to drive, or not."""
        if not drives:
            return self if self.told_ns is None else replace(self, told_ns=None)
        since_ns = 0 if self.told_ns is None else now_ns - self.told_ns
        return Still(self.picture, self.driven_ns + since_ns, now_ns)


MOVING = Still()


def picture_of(data: bytes) -> bytes:
    """A few bytes by which a picture is known again."""
    return blake2b(data, digest_size=_DIGEST_BYTES).digest()
