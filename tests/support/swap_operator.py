"""An operator who offers policies to a running loop, says stop and reset, and holds it up."""

import os
import signal
import threading
import time
from dataclasses import dataclass, field

import numpy as np
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.messages.controls import encode_stop
from reflexarc_runtime.messages.topics import RESET, RETINA, STOP
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from support.offered_policies import Offer
from support.processes import Process, wait_until

ANSWERED_S = 100.0
STOPPED_MS = (80, 150)


@dataclass(frozen=True)
class Asked:
    """A policy that was offered, when, and what was answered."""

    kind: str
    while_moving: bool
    from_ns: int
    to_ns: int
    outcome: str
    words: str
    policy_hash: str


@dataclass
class Operator:
    """Offers policies, says stop and reset, and holds the runtime up."""

    bus: Bus
    runtime: Process
    draw: np.random.Generator
    asked: list[Asked] = field(default_factory=list)
    paused: list[tuple[int, int]] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._stop, self._reset = self.bus.publisher(STOP), self.bus.publisher(RESET)
        self._ended = threading.Event()
        self._pausing = threading.Thread(target=self._pause_now_and_then, daemon=True)

    def offer(self, offer: Offer, *, standing: bool) -> None:
        """Offer a policy, at standstill or while the robot drives."""
        if standing:
            self._stop.put(encode_stop("a campaign"), time.monotonic_ns())
        begun_ns = time.monotonic_ns()
        request = pb.SwapRequest(
            policy=offer.policy, reason=offer.kind, while_moving=not standing, patience_s=5.0
        )
        said = self.bus.request_swap(request.SerializeToString(), ANSWERED_S)
        answer = pb.SwapAnswer.FromString(said[0]) if said else None
        outcome = "unanswered" if answer is None else pb.SwapAnswer.Outcome.Name(answer.outcome)
        words = "" if answer is None else answer.words
        now_ns = time.monotonic_ns()
        identity, while_moving = policy_hash(offer.policy), not standing
        self.asked.append(
            Asked(offer.kind, while_moving, begun_ns, now_ns, outcome, words, identity)
        )
        self._judge(offer, outcome, words)
        if standing:
            self._reset.put(b"", time.monotonic_ns())
        time.sleep(float(self.draw.uniform(0.2, 1.0)))

    def _judge(self, offer: Offer, outcome: str, words: str) -> None:
        is_refused = outcome == "REFUSED"
        wanted = bool(offer.refused_for)
        if is_refused != wanted or (wanted and offer.refused_for not in words):
            self.failures.append(f"{offer.kind}: {outcome}: {words}")

    def begin(self) -> None:
        """From now on, hold the runtime up now and then."""
        self._pausing.start()

    def end(self) -> None:
        """No longer."""
        self._ended.set()
        self._pausing.join()

    def _pause_now_and_then(self) -> None:
        draw = np.random.default_rng(7)
        while not self._ended.wait(float(draw.uniform(2.0, 5.0))):
            begun_ns = time.monotonic_ns()
            os.kill(self.runtime.pid, signal.SIGSTOP)
            time.sleep(draw.integers(*STOPPED_MS) / 1000)
            os.kill(self.runtime.pid, signal.SIGCONT)
            self.paused.append((begun_ns, time.monotonic_ns()))


def brightness(bus: Bus, count: int = 200) -> float:
    """What the robot sees on a bright moment, in the mean of a retina: its 80th percentile."""
    means: list[float] = []

    def hear(message: Message) -> None:
        try:
            data = RawImage.FromString(message.payload).data
        except DecodeError:
            return
        if data and len(means) < 10 * count:
            means.append(float(np.mean(np.frombuffer(data, np.uint8))))

    bus.subscribe([RETINA], hear)
    wait_until(lambda: len(means) >= count, f"{count} retinas")
    return float(np.percentile(means, 80))
