"""What a loop and the process of its shadow say to each other, over a socket of whole messages."""

import struct

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.serving.shadowing import ShadowTick

READY = b"ready"
"""The first thing that the process says."""
MOST_ANSWER_BYTES = 4096
"""Of one answer: 64 actions take a tenth of it."""

_BEGINS, _NEWER = 1, 2
_TICK = struct.Struct("<QQiB")
_ANSWER = struct.Struct("<??")


def pack_tick(tick: ShadowTick) -> bytes:
    """A tick as a message."""
    flags = _BEGINS * tick.begins | _NEWER * tick.is_newer
    return _TICK.pack(tick.index, tick.slot, tick.drove, flags) + tick.retina


def unpack_tick(data: bytes) -> ShadowTick:
    """Read it back."""
    index, slot, drove, flags = _TICK.unpack_from(data)
    retina = data[_TICK.size :]
    return ShadowTick(index, slot, retina, drove, bool(flags & _BEGINS), bool(flags & _NEWER))


def pack_answer(said: pb.Shadow) -> bytes:
    """What a shadow said, with what is counted of it in front, so that the loop decodes nothing."""
    failed = bool(said.fault)
    differs = not failed and said.winner != said.drove
    return _ANSWER.pack(failed, differs) + said.SerializeToString()


def unpack_answer(data: bytes) -> tuple[bool, bool, bytes]:
    """Whether it failed, whether it preferred something else, and the message."""
    failed, differs = _ANSWER.unpack_from(data)
    return failed, differs, data[_ANSWER.size :]
