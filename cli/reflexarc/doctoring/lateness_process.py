"""The process in which a loop's punctuality is tried: see `lateness_trial`.

    python -m reflexarc.doctoring.lateness_process ROLE RATE_HZ SECONDS FIFO [POLICY BACKEND]

`loop` is the runtime's own loop, without a bus: its pacer and its clock, nothing rehearsed; with a
policy, its whole ticks, each on a golden retina. `c` is the bare call of the C library,
clock_nanosleep, from the same thread. It prints one JSON object.
"""

import ctypes
import json
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.loop.cadence.histogram import Histogram, add_each
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import NoOutlet, Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.loop.realtime import Realtime, RealtimeSettings
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, RETINA
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.sensing.senses import sense_for

_ABSOLUTE = 1
_WARM = 10
"""Ticks at the beginning that are not counted, where no node counts them."""


def main(
    role: str, rate_hz: float, seconds: float, fifo: int, path: Path | None, backend: str
) -> None:
    """Try it, and print how long each phase took. Nothing moves: any speed may be asked for."""
    ticks = max(20, round(rate_hz * seconds))
    policy = None if path is None else load_policy(path, backend, bounds=None)
    with Realtime(RealtimeSettings(fifo, whole_machine=fifo > 0)) as realtime:
        asked = [grant for grant in realtime.grants if grant.asked.startswith("SCHED")]
        if any(grant.refusal for grant in asked):
            sys.exit("; ".join(grant.words for grant in asked))
        if role == "c":
            phases = _late(rate_hz, ticks, _sleep_in_c())
        elif policy is None:
            phases = _late(rate_hz, ticks, MonotonicClock().sleep_until_ns)
        else:
            phases = _phases(policy, rate_hz, ticks)
    print(json.dumps(phases))


def _phases(policy: LoadedPolicy, rate_hz: float, ticks: int) -> dict[str, object]:
    """Those of a node that hears one golden retina a tick."""
    inbox, clock = Inbox(), MonotonicClock()
    contract = policy.contract
    sense = sense_for("retina", contract.retina)
    controller = Controller(policy, contract, sense, policy.policy_hash)
    feed = _feeder(policy, inbox, clock.now_ns)

    def saw(decision: Decision) -> None:
        feed(decision.index)

    nowhere = NoOutlet()
    pacer = RatePacer(rate_hz, clock, inbox)
    node = Node(controller, pacer, Outlets(nowhere, nowhere, nowhere), saw=saw)
    feed(0)
    summary = node.run(max_ticks=ticks)
    found: dict[str, object] = {name: asdict(each) for name, each in summary.phases.items()}
    return {**found, "skipped": summary.skipped_slots}


def _feeder(policy: LoadedPolicy, inbox: Inbox, now_ns: Callable[[], int]) -> Callable[[int], None]:
    """Puts the next golden retina into the inbox."""
    spec, golden = policy.contract.retina, policy.contract.golden.retinas
    retinas = [np.array(each, np.uint8).reshape(spec.stack_shape)[-1] for each in golden]
    key, encoding = RETINA.key(DEFAULT_ROBOT), protobuf_encoding(RETINA.schema)

    def feed(index: int) -> None:
        at_ns = now_ns()
        payload = encode_retina(retinas[index % len(retinas)], spec, at_ns)
        inbox.put(Message(key, payload, encoding, pack_stamp(Stamp(index, at_ns)), at_ns))

    return feed


def _late(rate_hz: float, ticks: int, sleep_until_ns: Callable[[int], None]) -> dict[str, object]:
    """How late it woke, slot by slot; a missed one is left out, as in the loop."""
    found, period_ns = Histogram(), round(1e9 / rate_hz)
    begin_ns, slot = time.monotonic_ns(), 0
    for count in range(ticks):
        slot = max(slot + 1, (time.monotonic_ns() - begin_ns) // period_ns)
        deadline_ns = begin_ns + slot * period_ns
        sleep_until_ns(deadline_ns)
        late_ns = time.monotonic_ns() - deadline_ns
        if count >= _WARM:
            add_each((max(0, late_ns),), (found,))
    return {"lateness": asdict(found.spread())}


class _TimeSpec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


def _sleep_in_c() -> Callable[[int], None]:
    call, spec = ctypes.CDLL(None).clock_nanosleep, _TimeSpec()
    until = ctypes.byref(spec)

    def sleep_until_ns(deadline_ns: int) -> None:
        spec.seconds, spec.nanoseconds = divmod(deadline_ns, 1_000_000_000)
        call(time.CLOCK_MONOTONIC, _ABSOLUTE, until, None)

    return sleep_until_ns


if __name__ == "__main__":
    _role, _rate_hz, _seconds, _fifo, *_rest = sys.argv[1:]
    _path, _backend = (Path(_rest[0]), _rest[1]) if _rest else (None, "")
    main(_role, float(_rate_hz), float(_seconds), int(_fifo), _path, _backend)
