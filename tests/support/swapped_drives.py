"""Drives in which policies take over from each other, on a clock that moves by itself."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.guard import Guard, asks_the_input
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.controls import encode_overrun, encode_stop, encode_swap
from reflexarc_runtime.messages.topics import OVERRUN, RESET, SHADOW, STOP, SWAP, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.model_file import policy_hash, with_contract
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_runtime.serving.shadowing import ShadowMind, ShadowTick
from reflexarc_runtime.serving.swapping import SwappingController, controller_for
from support.policies import network
from support.recordings import (
    MS,
    PERIOD_NS,
    RUN,
    START_NS,
    WALL_OFFSET_NS,
    Nowhere,
    ScheduledClock,
)

BRIGHTEST = 150.0
"""Mean intensity beyond which a policy of `fails_in_the_light` gives no number."""


def message_at(slot: int, topic: Topic, payload: bytes, number: int = 0) -> Message:
    """A message that is in the inbox 2 ms before the deadline of a slot."""
    received_ns = START_NS + slot * PERIOD_NS - 2 * MS
    stamp = pack_stamp(Stamp(number, received_ns))
    return Message(
        topic.key("robot0"), payload, protobuf_encoding(topic.schema), stamp, received_ns
    )


def swap_at(slot: int, policy: bytes, *, while_moving: bool = False) -> Message:
    """A swap as a runtime puts it into its own inbox."""
    payload = encode_swap(policy, policy_hash(policy), "a test", while_moving=while_moving)
    return message_at(slot, SWAP, payload, slot)


def stop_at(slot: int) -> Message:
    """Somebody says stop."""
    return message_at(slot, STOP, encode_stop("a test"), slot)


def reset_at(slot: int) -> Message:
    """The stop holds no longer."""
    return message_at(slot, RESET, b"", slot)


def overrun_at(slot: int) -> Message:
    """The watchdog says that the tick before was late."""
    return message_at(slot, OVERRUN, encode_overrun(START_NS, 60 * MS), slot)


def fails_in_the_light(
    contract: PolicyContract, seed: int = 0, brightest: float = BRIGHTEST
) -> bytes:
    """A policy of random weights that gives NaN where the mean of what it sees is beyond a limit.

    So it is intact by its golden vectors, which are dark.
    """
    model = onnx.ModelProto.FromString(network(contract, seed))
    for node in model.graph.node:
        for place, name in enumerate(node.output):
            if name == "q_values":
                node.output[place] = "plain"
    choice = model.graph.node.pop()
    limit = numpy_helper.from_array(np.array(brightest, np.float32), "limit")
    nothing = numpy_helper.from_array(np.array(0.0, np.float32), "nothing")
    model.graph.initializer.extend([limit, nothing])
    model.graph.node.extend(
        [
            helper.make_node("Cast", ["retina"], ["light"], to=TensorProto.FLOAT),
            helper.make_node("Flatten", ["light"], ["lights"], axis=1),
            helper.make_node("ReduceMean", ["lights"], ["mean"], axes=[1], keepdims=1),
            helper.make_node("Sub", ["limit", "mean"], ["left"]),
            helper.make_node("Sqrt", ["left"], ["root"]),
            helper.make_node("Mul", ["root", "nothing"], ["zero"]),
            helper.make_node("Add", ["plain", "zero"], ["q_values"]),
            choice,
        ]
    )
    dark = np.random.default_rng(seed).integers(0, 200, (8, *contract.retina.stack_shape), np.uint8)
    dark = np.minimum(dark, int(brightest) - 10 if brightest > 20.0 else 0).astype(np.uint8)
    bare = load_policy(with_contract(model.SerializeToString(), contract), verify=False)
    q_values, actions = bare.decide(dark)
    golden = GoldenVectors(
        tuple(tuple(row) for row in dark.reshape(len(dark), -1).tolist()),
        tuple(tuple(row) for row in q_values.tolist()),
        tuple(actions.tolist()),
    )
    return with_contract(model.SerializeToString(), replace(contract, golden=golden))


@dataclass
class ShadowHere:
    """A shadow that answers at once, and misses every tenth tick."""

    policy: LoadedPolicy
    recorder: Recorder
    said: list[pb.Shadow] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._mind, self._begins, self._input, self._ticks = (
            ShadowMind(self.policy),
            True,
            (0, 0),
            0,
        )

    def saw(self, decision: Decision) -> None:
        """What `Shadow.saw` does, without a process."""
        self._ticks += 1
        if not decision.retina or self._ticks % 10 == 0 or decision.input is None:
            self._begins = True
            return
        came = decision.input.sequence, decision.input.source_time_ns
        tick = ShadowTick(
            decision.index,
            decision.slot,
            decision.retina,
            decision.winner,
            self._begins,
            came != self._input,
        )
        self._input, self._begins = came, False
        self.said.append(self._mind.decide(tick))
        payload = self.said[-1].SerializeToString()
        stamp = pack_stamp(Stamp(len(self.said), decision.now_ns))
        encoding = protobuf_encoding(SHADOW.schema)
        self.recorder.put(Message("robot0/shadow", payload, encoding, stamp, decision.now_ns))


def swapped_drive(
    path: Path,
    policies: Sequence[bytes],
    schedule: Mapping[int, Iterable[Message]],
    ticks: int,
    *,
    run: RunInfo = RUN,
    shadow: bytes | None = None,
    others: Mapping[str, bytes] | None = None,
    **more: object,
) -> list[Decision]:
    """Record a drive that begins with the first policy; returns what was decided."""
    loaded = [load_policy(policy, run.backend) for policy in policies]
    inbox = Inbox()
    pacer = RatePacer(1e9 / PERIOD_NS, ScheduledClock(inbox, schedule, {}), inbox)
    contract, guard = loaded[0].contract, None
    if run.guard:
        guard = Guard.for_contract(GuardSettings.from_json(run.guard), contract)
    senses = SenseSettings.from_json(run.senses) if run.senses else SenseSettings()
    sense = sense_for(run.input, contract.retina, senses, guarded=asks_the_input(guard))
    first = Controller(loaded[0], contract, sense, loaded[0].policy_hash, guard=guard)
    known = {one.policy_hash: controller_for(one, first) for one in loaded[1:]}
    decided: list[Decision] = []
    beside = dict(others or {})
    if shadow is not None:
        beside[policy_hash(shadow)] = shadow
    with Recorder(
        path,
        run,
        policies[0],
        {},
        wall_offset_ns=WALL_OFFSET_NS,
        others=beside,
        **more,  # type: ignore[arg-type]  # what a recorder takes
    ) as recorder:
        watching = None if shadow is None else ShadowHere(load_policy(shadow), recorder)

        def saw(decision: Decision) -> None:
            decided.append(decision)
            if watching is not None:
                watching.saw(decision)

        outlets = Outlets(Nowhere(), Nowhere(), Nowhere())
        controller = SwappingController(first, known)
        Node(controller, pacer, outlets, sink=recorder, saw=saw).run(max_ticks=ticks)
    return decided


def verdicts(decided: Iterable[Decision]) -> Counter[str]:
    """How often each verdict was given."""
    return Counter(one.verdict.name for one in decided)
