"""What a shadow costs the loop: waking to command, and what follows it, with one and without.

    python benchmarks/shadow.py [--rate-hz 1000] [--ticks 3000] [--rounds 4]

In turns, round by round: no shadow; one that follows; one that hangs (its process is stopped). The
loop is the real one on the real clock, with outlets that lead nowhere and a retina at every tick.
"""

import argparse
import os
import signal
import tempfile
import time
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.loop.candidates.shadow import Shadow
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import exported

KINDS = ("none", "follows", "hangs")


class FedClock(MonotonicClock):
    """Puts a retina into the inbox whenever it has slept."""

    def __init__(self, inbox: Inbox, payload: bytes) -> None:
        super().__init__()
        self.inbox, self.payload, self.count = inbox, payload, 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        now_ns = self.now_ns()
        stamp = pack_stamp(Stamp(self.count, now_ns))
        encoding = protobuf_encoding("foxglove.RawImage")
        self.inbox.put(Message("robot0/retina", self.payload, encoding, stamp, now_ns))
        self.count += 1
        super().sleep_until_ns(deadline_ns)


class Ticks:
    """An outlet that keeps what it is given."""

    def __init__(self) -> None:
        self.payloads: list[bytes] = []

    def put(self, payload: bytes, time_ns: int) -> None:
        """See `Outlet.put`."""
        self.payloads.append(payload)


def measure(
    kind: str, rate_hz: float, ticks: int, path: Path
) -> tuple[np.ndarray, np.ndarray, str]:
    """Waking to command, and the shadow's own part behind it, ns (ticks,); and what it did."""
    policy = load_policy(path)
    contract = policy.contract
    payload = encode_retina(np.full(contract.retina.shape, 90, np.uint8), contract.retina, 0)
    inbox, kept = Inbox(), Ticks()
    pacer = RatePacer(rate_hz, FedClock(inbox, payload), inbox)
    controller = Controller(policy, contract, RetinaSense(contract.retina), policy.policy_hash)
    nowhere = Ticks()
    watching = nullcontext()
    if kind != "none":
        put = nowhere.payloads.append
        watching = Shadow(path.read_bytes(), "numpy", put, robot="robot0")
    spent_ns: list[int] = []
    with watching as shadow:
        if kind == "hangs":
            os.kill(shadow.pid, signal.SIGSTOP)

        def saw(decision: Decision) -> None:
            if shadow is not None:
                began_ns = time.perf_counter_ns()
                shadow.saw(decision)
                spent_ns.append(time.perf_counter_ns() - began_ns)

        Node(controller, pacer, Outlets(Ticks(), kept, Ticks()), saw=saw).run(max_ticks=ticks)
        words = "" if shadow is None else shadow.state
    timings = [Tick.FromString(each).timing for each in kept.payloads]
    whole = [t.receive_ns + t.decide_ns + t.publish_ns for t in timings]
    return np.array(whole[50:]), np.array(spent_ns[50:] or [0]), words


def main() -> None:
    """Measure, and print a table."""
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("--rate-hz", type=float, default=1000.0)
    flags.add_argument("--ticks", type=int, default=3000)
    flags.add_argument("--rounds", type=int, default=4)
    given = flags.parse_args()
    contract = replace(PolicyContract(retina=RetinaSpec(rays=16)), rate_hz=given.rate_hz)
    realtime.prepare()
    rounds: dict[str, list[tuple[float, ...]]] = {kind: [] for kind in KINDS}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "policy.onnx"
        path.write_bytes(exported(contract, seed=1))
        for _ in range(given.rounds):
            for kind in KINDS:
                whole, spent, words = measure(kind, given.rate_hz, given.ticks, path)
                row = (*np.percentile(whole, (50, 99)), *np.percentile(spent, (50, 99)))
                rounds[kind].append(tuple(float(each) / 1e3 for each in row))
    print("medians of rounds, µs    waking→command p50     p99   its own part p50     p99")
    for kind, rows in rounds.items():
        values = np.median(np.array(rows), axis=0)
        print(
            f"{kind:10} {'':20}{values[0]:12.1f}{values[1]:8.1f}{values[2]:19.1f}{values[3]:8.1f}"
        )
    print(f"load {os.getloadavg()[0]:.1f}; the last one: {words}")


if __name__ == "__main__":
    main()
