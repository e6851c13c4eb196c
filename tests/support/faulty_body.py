"""A body for fault campaigns: sends retinas through a fault script, obeys commands, notes all.

    python tests/support/faulty_body.py --port 20001 --script seed:17 --seconds 3.4 --out body.json

A process of its own. It sees at 50 Hz, looks at its watchdog at 200 Hz, and writes at the end what
it sent (with the truth about it), what it heard and what it obeyed, all on its own clock.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.codec import decode_command, encode_retina
from reflexarc_runtime.messages.topics import BODY_NODE, COMMAND, RETINA
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.faults.delayed_sender import DelayedSender
from reflexarc_sim_bridge.body.faults.faulty_stream import Sending
from reflexarc_sim_bridge.body.faults.random_script import script_named
from reflexarc_sim_bridge.body.faults.script import FaultScript

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package
from support.body_watchdog import Watchdog  # it is found there

POLL_HZ = 200.0
POLLS_PER_RETINA = 4
PATIENCE_S = 30.0

CLOCK = MonotonicClock()
CONTRACT = PolicyContract()


class FaultyBody:
    """What it hears, sends and obeys."""

    def __init__(self, bus: Bus, script: FaultScript) -> None:
        self._script = script
        self._publisher = bus.publisher(RETINA)
        self._watchdog = Watchdog(CONTRACT.safe_command)
        self.sent: list[tuple[int, int | None]] = []
        self.heard: list[tuple[int, str, int | None]] = []
        self.polls: list[tuple[int, int, bool]] = []
        bus.subscribe([COMMAND], self._hear)
        bus.announce(BODY_NODE)

    def is_joined(self) -> bool:
        """Whether somebody listens, and speaks."""
        return bool(self._publisher.has_listener and self.heard)

    def live(self, seconds: float) -> None:
        """Send, listen and obey for a time."""
        rng = np.random.default_rng(self._script.seed)
        pacer = RatePacer(POLL_HZ, CLOCK, Inbox())
        picture = np.full(CONTRACT.retina.shape, 96.0)
        with DelayedSender(self._script, self._send, CLOCK.now_ns) as sender:
            for poll in range(round(seconds * POLL_HZ)):
                wakeup = pacer.wait(lambda: False)
                assert wakeup is not None
                self._obey(wakeup.deadline_ns)
                if poll % POLLS_PER_RETINA == 0:
                    picture = np.clip(picture + rng.normal(0.0, 12.0, picture.shape), 0.0, 255.0)
                    now_ns = CLOCK.now_ns()
                    retina = picture.astype(np.uint8)
                    sender.put(encode_retina(retina, CONTRACT.retina, now_ns), now_ns)

    def as_dict(self) -> dict[str, object]:
        return {"sent": self.sent, "heard": self.heard, "polls": self.polls}

    def _send(self, sending: Sending) -> None:
        self.sent.append((CLOCK.now_ns(), sending.seen_ns))
        self._publisher.put_raw(sending.payload, sending.attachment, sending.encoding)

    def _hear(self, message: Message) -> None:
        command = decode_command(message.payload)
        if command is not None:
            self.heard.append((message.received_ns, command.verdict.name, command.source_time_ns))
            self._watchdog = self._watchdog.heard(command)

    def _obey(self, deadline_ns: int) -> None:
        now_ns = CLOCK.now_ns()
        command = self._watchdog.obeyed(now_ns)
        driving = command is not None and not command.is_safe
        self.polls.append((now_ns, now_ns - deadline_ns, driving))


def main() -> None:
    arguments = _arguments()
    script = FaultScript(()) if arguments.script == "none" else script_named(arguments.script)
    realtime.prepare()
    with Bus(BusConfig(port=arguments.port, listens=True), CLOCK.now_ns) as bus:
        body = FaultyBody(bus, script)
        _wait_for_runtime(body)
        print("joined", flush=True)
        body.live(arguments.seconds)
    arguments.out.write_text(json.dumps(body.as_dict()))


def _wait_for_runtime(body: FaultyBody) -> None:
    pacer = RatePacer(POLL_HZ, CLOCK, Inbox())
    for _ in range(round(PATIENCE_S * POLL_HZ)):
        pacer.wait(lambda: False)
        if body.is_joined():
            return
    raise SystemExit("no runtime came")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--script", required=True, help="none, seed:N or a TOML file")
    parser.add_argument("--seconds", type=float, default=3.4)
    parser.add_argument("--out", type=Path, required=True)
    return parser.parse_args()


if __name__ == "__main__":
    main()
