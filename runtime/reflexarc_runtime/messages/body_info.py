"""What a body says about itself and where it is: enough to build the same world again.

The text of a world's file, a seed, the number of the robot and the period of the simulation are
one world and one place in it, to the bit.
"""

import math
from dataclasses import dataclass

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.errors import ContractError


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
    if not 0.0 <= message.step_s < math.inf:
        return None
    try:
        limits = _limits_of(message.limits) if message.HasField("limits") else None
    except ContractError:
        return None
    return BodyInfo(
        message.world, message.world_text, message.seed, message.number, message.step_s, limits
    )


def _limits_to_protobuf(limits: BodyLimits) -> pb.BodyLimits:
    accelerates, expires = limits.acceleration_mps2 < math.inf, limits.valid_for_s < math.inf
    return pb.BodyLimits(
        linear_mps=limits.linear_mps,
        lateral_mps=limits.lateral_mps,
        angular_radps=limits.angular_radps,
        acceleration_mps2=limits.acceleration_mps2 if accelerates else None,
        valid_for_ns=limits.valid_for_ns if expires else None,
    )


def _limits_of(message: pb.BodyLimits) -> BodyLimits:
    accelerates, expires = message.HasField("acceleration_mps2"), message.HasField("valid_for_ns")
    return BodyLimits(
        message.linear_mps,
        message.lateral_mps,
        message.angular_radps,
        message.acceleration_mps2 if accelerates else math.inf,
        message.valid_for_ns / 1e9 if expires else math.inf,
    )
