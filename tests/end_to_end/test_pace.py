"""`reflexarc run --pace input` as a real process, with a body that sends at odd times."""

import random
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import RETINA
from support.processes import finished, started

CONTRACT = PolicyContract()
TICKS = 150
FLOODED = 100
"""Retinas that are sent at once, in the middle."""


def send(bus: Bus, until: threading.Event) -> None:
    """A retina every 20 to 24 ms; once, many at once."""
    publisher, jitter = bus.publisher(RETINA), random.Random(3)
    picture = np.zeros(CONTRACT.retina.shape, np.uint8)
    while not until.wait(jitter.uniform(0.02, 0.024)):
        for _ in range(FLOODED if publisher.next_sequence == 80 else 1):
            now_ns = time.monotonic_ns()
            publisher.put(encode_retina(picture, CONTRACT.retina, now_ns), now_ns)


@pytest.mark.long
def test_ticks_begin_at_inputs_and_the_log_replays(policy: Path, port: int, tmp_path: Path):
    log, until = tmp_path / "drive.mcap", threading.Event()
    with Bus(BusConfig("robot0", port, listens=True), time.monotonic_ns) as bus:
        body = threading.Thread(target=send, args=(bus, until))
        body.start()
        words = ("run", policy, "--port", port, "--pace", "input", "--record", log)
        try:
            with started(*words, "--no-guard", "--ticks", TICKS, "--json") as loop:
                summary = finished(loop)
        finally:
            until.set()
            body.join()
    read = read_log(log)
    ticks = list(read.ticks())
    assert read.run.pace == "input"
    begun_ns = [tick.decision.now_ns - tick.timing.receive_ns for tick in ticks[:-1]]
    least_ns = (TICKS - 1) * 20_000_000 - 10_000_000
    assert begun_ns[-1] - begun_ns[0] >= least_ns - 20_000_000  # never quicker than the rate
    assert summary["phases"]["picture age"]["count"] == summary["verdicts"]["OK"]
    at_inputs = [tick for tick in ticks[:-1] if tick.decision.inputs]
    prompt = [
        tick
        for tick in at_inputs
        if tick.decision.now_ns - tick.timing.receive_ns - tick.timing.lateness_ns
        == tick.decision.input.received_ns
    ]
    assert len(prompt) > 0.8 * len(at_inputs)  # due at the very arrival of their input
    assert replay(log).exit_status == 0
