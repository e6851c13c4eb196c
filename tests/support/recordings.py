"""Runs of the real node on a clock that moves by itself, recorded as a robot would record them."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.guard import Guard, asks_the_input
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import sense_for

MS = 1_000_000
PERIOD_NS = 20 * MS
START_NS = 5_000 * MS
WALL_OFFSET_NS = 1_700_000_000_000_000_000
KEY = "robot0/retina"
ENCODING = protobuf_encoding("foxglove.RawImage")
CONTRACT = PolicyContract(retina=RetinaSpec(rays=16))
RUN = RunInfo(run_id="5eed" * 8, rate_hz=50.0, host="golden", commit="golden")

NO_STALLS: Mapping[int, int] = {}
FAULT_STALLS = {270: 65 * MS}
"""The loop oversleeps once, and skips three slots."""

Schedule = Mapping[int, Iterable[Message]]
"""Messages by the slot at whose deadline they are in the inbox."""


class ScheduledClock(ManualClock):
    """A clock that fills the inbox whenever it is slept on, and may oversleep, by a schedule."""

    def __init__(self, inbox: Inbox, schedule: Schedule, stalls: Mapping[int, int]) -> None:
        super().__init__(START_NS)
        self._inbox, self._schedule, self._stalls = inbox, schedule, stalls
        self._slot = 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        super().sleep_until_ns(deadline_ns)
        self.time_ns += self._stalls.get((deadline_ns - START_NS) // PERIOD_NS, 0)
        while self._slot * PERIOD_NS <= self.time_ns - START_NS:
            for message in self._schedule.get(self._slot, ()):
                self._inbox.put(message)
            self._slot += 1


class Nowhere:
    """An outlet that leads nowhere."""

    def put(self, payload: bytes, time_ns: int) -> None:
        pass


def drive(
    path: Path,
    policy: bytes | LoadedPolicy,
    schedule: Schedule,
    ticks: int,
    *,
    run: RunInfo = RUN,
    stalls: Mapping[int, int] = NO_STALLS,
    before: Iterable[Message] = (),
    after: Iterable[Message] = (),
    **more: Any,
) -> Counter[str]:
    """Record `ticks` ticks and the farewell to `path`; returns the verdict counts.

    `stalls` says at which slot the loop oversleeps by how many ns; `before` and `after` go past
    the loop, straight to the recorder; `more` is for the recorder.
    """
    loaded = policy if isinstance(policy, LoadedPolicy) else load_policy(policy, run.backend)
    inbox = Inbox()
    pacer = RatePacer(1e9 / PERIOD_NS, ScheduledClock(inbox, schedule, stalls), inbox)
    guard = None
    if run.guard:
        guard = Guard.for_contract(GuardSettings.from_json(run.guard), loaded.contract)
    senses = SenseSettings.from_json(run.senses) if run.senses else SenseSettings()
    eye, guarded = loaded.contract.retina, asks_the_input(guard)
    sense = sense_for(run.input, eye, senses, guarded=guarded)
    controller = Controller(loaded, loaded.contract, sense, loaded.policy_hash, guard=guard)
    outlets = Outlets(Nowhere(), Nowhere(), Nowhere())
    config = {"rate_hz": 50.0, "input": run.input}
    with Recorder(
        path, run, loaded.data, config, wall_offset_ns=WALL_OFFSET_NS, **more
    ) as recorder:
        for message in before:
            recorder.put(message)
        summary = Node(controller, pacer, outlets, sink=recorder).run(max_ticks=ticks)
        for message in after:
            recorder.put(message)
    return Counter(summary.verdicts)


def smooth_retinas(count: int, seed: int = 0, spec: RetinaSpec = CONTRACT.retina) -> np.ndarray:
    """Retinas (count, eyes, rays, channels), uint8, that change slowly, as things seen do."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(count, *spec.shape)).cumsum(axis=0)
    return np.clip(96 + 12 * steps, 0, 255).astype(np.uint8)


def retina_at(slot: int, retina: np.ndarray, sequence: int | None = None) -> Message:
    """The retina that arrives 3 ms before the deadline of a slot, 1 ms after it was sent."""
    received_ns = START_NS + slot * PERIOD_NS - 3 * MS
    sent_ns = received_ns - MS
    payload = encode_retina(retina, CONTRACT.retina, sent_ns)
    stamp = pack_stamp(Stamp(slot if sequence is None else sequence, sent_ns))
    return Message(KEY, payload, ENCODING, stamp, received_ns)


def nominal(ticks: int, seed: int = 0) -> dict[int, list[Message]]:
    """One retina a slot."""
    retinas = smooth_retinas(ticks, seed)
    return {slot: [retina_at(slot, retinas[slot - 1])] for slot in range(1, ticks + 1)}


def faults(ticks: int = 300, seed: int = 1) -> dict[int, list[Message]]:
    """Retinas that come late, twice, in the wrong order, broken, frozen, or not at all."""
    schedule = nominal(ticks, seed)
    for slot in range(1, 6):
        schedule[slot] = []  # the body starts late
    for slot in range(40, 52):
        schedule[slot] = []  # a gap, longer than the age that the contract allows
    for slot, broken in zip(range(70, 150, 10), _broken(schedule[70][0]), strict=True):
        received_ns = broken.received_ns + (slot - 70) * PERIOD_NS
        schedule[slot] = [replace(broken, received_ns=received_ns)]
    schedule[160] = schedule[160] * 2  # twice
    schedule[171], schedule[172] = [], [*schedule[172], *schedule[171]]  # the wrong way round
    frozen = schedule[200][0]
    for slot in range(201, 220):
        schedule[slot] = [replace(frozen, received_ns=START_NS + slot * PERIOD_NS - 3 * MS)]
    for slot in range(240, 244):
        schedule[slot + 4] = [*schedule[slot], *schedule[slot + 4]]  # four come late, together
        schedule[slot] = []
    return schedule


def _broken(good: Message) -> list[Message]:
    """What a body may send by mistake; one of each."""
    narrow = encode_retina(np.zeros((1, 8, 1), np.uint8), RetinaSpec(rays=8), 0)
    return [
        replace(good, payload=b"\xff\xff\xff\xff"),
        replace(good, payload=good.payload[:-5]),
        replace(good, payload=narrow),
        replace(good, payload=b""),
        replace(good, encoding="application/json"),
        replace(good, encoding=protobuf_encoding("foxglove.LaserScan")),
        replace(good, attachment=b""),
        replace(good, attachment=pack_stamp(Stamp(-1, 0))),
    ]
