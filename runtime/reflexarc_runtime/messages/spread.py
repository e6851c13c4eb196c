"""How the times of one phase of a loop were spread: plain values, and `reflexarc.PhaseTimes`."""

from dataclasses import dataclass

from reflexarc_runtime import messages_pb2 as pb


@dataclass(frozen=True, slots=True)
class Spread:
    """How many times there were, and how they were spread."""

    count: int = 0
    p50_ns: int = 0
    p99_ns: int = 0
    p999_ns: int = 0
    max_ns: int = 0
    least_bits: int = 0
    """Times in `octaves[n]` have `least_bits + n` bits: 2^(bits − 1) ns and more, below 2^bits."""
    octaves: tuple[int, ...] = ()
    """How many times there were in each power of two, from the first to the last that has any."""
    sum_ns: int = 0
    """Of all of them, right to 1.6 %."""


def spread_to_protobuf(phase: str, spread: Spread) -> pb.PhaseTimes:
    """The times of one phase as `reflexarc.PhaseTimes`."""
    return pb.PhaseTimes(
        phase=phase,
        count=spread.count,
        p50_ns=spread.p50_ns,
        p99_ns=spread.p99_ns,
        p999_ns=spread.p999_ns,
        max_ns=spread.max_ns,
        least_bits=spread.least_bits,
        octaves=spread.octaves,
        sum_ns=spread.sum_ns,
    )
