"""What a body says about itself and where it is: enough to build the same world again.

The text of a world's file, a seed, the number of the robot and the period of the simulation are
one world and one place in it, to the bit.
"""

import math
from dataclasses import astuple, dataclass

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Command


@dataclass(frozen=True, slots=True)
class BodyLimits:
    """What a body does at most, whatever it is told; 0: it does not move so at all."""

    linear_mps: float
    lateral_mps: float
    angular_radps: float

    def allow(self, command: Command) -> bool:
        """Whether no speed of a command is beyond them."""
        return (
            abs(command.linear_mps) <= self.linear_mps
            and abs(command.lateral_mps) <= self.lateral_mps
            and abs(command.angular_radps) <= self.angular_radps
        )


@dataclass(frozen=True, slots=True)
class BodyInfo:
    """A body and where it is; by default one that is not simulated, and says nothing of limits."""

    world: str = ""
    """Name of its world."""
    world_text: str = ""
    """The world's file (TOML), ranges and all: the seed draws from them as it did."""
    seed: int = 0
    """Which of the world's endless variants."""
    number: int = 0
    """Which of several robots in one world."""
    step_s: float = 0.0
    """Period of the simulation; 0: not simulated."""
    limits: BodyLimits | None = None
    """None: it has none of its own."""


def encode_body(info: BodyInfo) -> bytes:
    """`reflexarc.Body`."""
    message = pb.Body(
        world=info.world,
        world_text=info.world_text,
        seed=info.seed,
        number=info.number,
        step_s=info.step_s,
        limits=None if info.limits is None else _limits_to_protobuf(info.limits),
    )
    return message.SerializeToString()


def decode_body(payload: bytes) -> BodyInfo | None:
    """What a body said; None if it cannot be decoded, or its numbers are no speeds and times."""
    try:
        message = pb.Body.FromString(payload)
    except DecodeError:
        return None
    limits = _limits_of(message.limits) if message.HasField("limits") else None
    numbers = (message.step_s, *(astuple(limits) if limits else ()))
    if not all(0.0 <= number < math.inf for number in numbers):
        return None
    return BodyInfo(
        message.world, message.world_text, message.seed, message.number, message.step_s, limits
    )


def _limits_to_protobuf(limits: BodyLimits) -> pb.BodyLimits:
    return pb.BodyLimits(
        linear_mps=limits.linear_mps,
        lateral_mps=limits.lateral_mps,
        angular_radps=limits.angular_radps,
    )


def _limits_of(message: pb.BodyLimits) -> BodyLimits:
    return BodyLimits(message.linear_mps, message.lateral_mps, message.angular_radps)
