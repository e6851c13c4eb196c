"""Injected faults: what becomes of a body's retinas between the body and the bus.

    stream of (time, retina) → stream of (time, bytes, attachment, encoding)

Pure and seeded: no clock, no bus. Each sending also carries what no receiver can know: when its
picture was seen, or that it must not be used for driving. A judge of a run compares with that.
"""

import heapq
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_runtime.messages.topics import RETINA
from reflexarc_runtime.messages.wire import Stamp, pack_stamp, protobuf_encoding
from reflexarc_sim_bridge.body.faults.malformed import MessageParts, malformed
from reflexarc_sim_bridge.body.faults.script import (
    ClockStep,
    Delay,
    Duplication,
    Fault,
    FaultScript,
    Freezing,
    Frozen,
    Jitter,
    Loss,
    Malformed,
    Reordering,
    SecondSender,
    Silence,
)

_ENCODING = protobuf_encoding(RETINA.schema)
_SENDER_BYTES = 16


@dataclass(frozen=True, slots=True)
class Sending:
    """One message for the bus, and when to send it."""

    due_ns: int
    """When to send it, on the body's clock."""
    payload: bytes
    attachment: bytes
    encoding: str
    seen_ns: int | None
    """When its picture was really seen, on the body's clock. None if it must not be used for
    driving: it is malformed, not of this body, or stamped with another time."""


@dataclass(frozen=True, slots=True)
class _Retina:
    """A retina before it is packed."""

    payload: bytes
    stamp: Stamp
    seen_ns: int | None


class _Sender:
    """An identity that numbers its messages from 0."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.identity = rng.bytes(_SENDER_BYTES)
        self._sequence = -1

    def stamp(self, time_ns: int) -> Stamp:
        self._sequence += 1
        return Stamp(self._sequence, time_ns)


class FaultyStream:
    """Turns each retina into the messages that a faulty body sends: none, one or many."""

    def __init__(self, script: FaultScript) -> None:
        self._script = script
        self._rng = np.random.default_rng(script.seed)
        self._own = _Sender(self._rng)
        self._others: dict[SecondSender, _Sender] = {}
        self._frozen: dict[Freezing, _Retina] = {}
        self._start_ns: int | None = None
        self._was_silent = False

    @property
    def sender(self) -> bytes:
        """The identifier that the body's own messages carry now; another one after a silence."""
        return self._own.identity

    def say(self, payload: bytes, time_ns: int) -> list[Sending]:
        """The messages that one retina becomes.

        Args:
            payload: the retina, `foxglove.RawImage`.
            time_ns: when it was seen, on the body's clock; never decreases.
        """
        self._start_ns = time_ns if self._start_ns is None else self._start_ns
        active = self._script.active((time_ns - self._start_ns) * 1e-9)
        sendings = [
            *self._own_messages(payload, time_ns, active),
            *self._other_messages(payload, time_ns, active),
        ]
        for fault in active:
            sendings = [out for sending in sendings for out in self._apply_on_way(fault, sending)]
        return sendings

    def _own_messages(
        self, payload: bytes, time_ns: int, active: tuple[Fault, ...]
    ) -> list[Sending]:
        """The body's own message; none while it is silent."""
        silent = any(isinstance(fault, Silence) for fault in active)
        if self._was_silent and not silent:
            self._own = _Sender(self._rng)
        self._was_silent = silent
        self._frozen = {fault: held for fault, held in self._frozen.items() if fault in active}
        if silent:
            return []
        retina = _Retina(payload, self._own.stamp(time_ns), time_ns)
        for fault in active:
            retina = self._apply_at_sender(fault, retina)
        return [_packed(retina, self._own, time_ns)]

    def _other_messages(
        self, payload: bytes, time_ns: int, active: tuple[Fault, ...]
    ) -> list[Sending]:
        """Messages of second senders; what one sends on the body's own clock counts as valid."""
        others = [fault for fault in active if isinstance(fault, SecondSender)]
        sendings = []
        for fault in others:
            sender = self._others.setdefault(fault, _Sender(self._rng))
            stamp = sender.stamp(_moved(time_ns, fault.ahead_s))
            seen_ns = time_ns if stamp.time_ns == time_ns else None
            sendings.append(_packed(_Retina(_blank(payload), stamp, seen_ns), sender, time_ns))
        return sendings

    def _apply_at_sender(self, fault: Fault, retina: _Retina) -> _Retina:
        """Apply a fault of the sender itself: freezing, or a clock that steps."""
        match fault:
            case Freezing():
                return _frozen(retina, self._frozen.setdefault(fault, retina), fault.what)
            case ClockStep():
                time_ns = _moved(retina.stamp.time_ns, fault.step_s)
                return replace(retina, stamp=replace(retina.stamp, time_ns=time_ns), seen_ns=None)
            case _:
                return retina

    def _apply_on_way(self, fault: Fault, sending: Sending) -> list[Sending]:
        """Apply a fault on the way: delay, loss, copies or damage."""
        match fault:
            case Delay():
                return [_later(sending, fault.delay_s)]
            case Jitter():
                return [_later(sending, self._rng.uniform(0.0, fault.jitter_s))]
            case Loss():
                return [] if self._strikes(fault.share) else [sending]
            case Duplication():
                return [sending] * (fault.copies if self._strikes(fault.share) else 1)
            case Reordering():
                return [_later(sending, fault.held_s if self._strikes(fault.share) else 0.0)]
            case Malformed():
                return [_spoilt(sending, fault) if self._strikes(fault.share) else sending]
            case _:
                return [sending]

    def _strikes(self, share: float) -> bool:
        return bool(self._rng.random() < share)


def transform(script: FaultScript, stream: Iterable[tuple[int, bytes]]) -> Iterator[Sending]:
    """A whole stream of (time in ns, retina), in the order in which it goes onto the bus."""
    faulty = FaultyStream(script)
    waiting: list[tuple[int, int, Sending]] = []
    pushed = 0
    for time_ns, payload in stream:
        while waiting and waiting[0][0] < time_ns:
            yield heapq.heappop(waiting)[2]
        for sending in faulty.say(payload, time_ns):
            heapq.heappush(waiting, (sending.due_ns, pushed, sending))
            pushed += 1
    while waiting:
        yield heapq.heappop(waiting)[2]


def _packed(retina: _Retina, sender: _Sender, time_ns: int) -> Sending:
    attachment = pack_stamp(replace(retina.stamp, sender=sender.identity))
    return Sending(time_ns, retina.payload, attachment, _ENCODING, retina.seen_ns)


def _frozen(retina: _Retina, held: _Retina, what: Frozen) -> _Retina:
    """The retina with a part of an earlier one.

    A frozen picture with a fresh stamp cannot be told from a good one by any receiver, so it counts
    as seen now. A fresh picture with a frozen time counts as seen at that time.
    """
    match what:
        case Frozen.IMAGE:
            return replace(retina, payload=held.payload)
        case Frozen.SEQUENCE:
            stamp = replace(retina.stamp, sequence=held.stamp.sequence)
            return replace(retina, stamp=stamp)
        case Frozen.TIME:
            stamp = replace(retina.stamp, time_ns=held.stamp.time_ns)
            return replace(retina, stamp=stamp, seen_ns=held.seen_ns)
        case Frozen.MESSAGE:
            return held


def _spoilt(sending: Sending, fault: Malformed) -> Sending:
    parts = malformed(
        MessageParts(sending.payload, sending.attachment, sending.encoding), fault.how
    )
    return Sending(sending.due_ns, parts.payload, parts.attachment, parts.encoding, None)


def _later(sending: Sending, by_s: float) -> Sending:
    return replace(sending, due_ns=sending.due_ns + round(by_s * 1e9))


def _moved(time_ns: int, by_s: float) -> int:
    """A time on a clock that is ahead; no stamp goes below zero."""
    return max(0, time_ns + round(by_s * 1e9))


def _blank(payload: bytes) -> bytes:
    """The same picture of a world without obstacles."""
    image = RawImage.FromString(payload)
    image.data = bytes(len(image.data))
    return image.SerializeToString()
