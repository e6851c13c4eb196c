"""A body without a world: it shows the same retina again and again, and remembers its commands."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import BODY_NODE, COMMAND, OVERRUN, RETINA, STATUS
from reflexarc_runtime.messages.wire import Message

DARK, USUAL, SPECIAL = 0, 90, 200


class PlainBody:
    """What it heard; and what it shows."""

    def __init__(self) -> None:
        self.heard: list[tuple[int, pb.Command]] = []
        """When, on the monotonic clock, and what."""
        self.overruns: list[pb.Overrun] = []
        self.watchdogs: list[str] = []
        """What each status said of the watchdog."""
        self.intensity = USUAL
        """Of every ray of the retinas that it shows."""

    def hear(self, message: Message) -> None:
        """Take one message of a runtime's."""
        if message.key.endswith(COMMAND.name):
            self.heard.append((message.received_ns, pb.Command.FromString(message.payload)))
        elif message.key.endswith(OVERRUN.name):
            self.overruns.append(pb.Overrun.FromString(message.payload))
        else:
            self.watchdogs.append(pb.Status.FromString(message.payload).watchdog)

    @property
    def verdicts(self) -> list[str]:
        """The verdicts of all commands, in the order in which they came."""
        return [pb.Verdict.Name(command.verdict) for _, command in self.heard]

    @property
    def last(self) -> pb.Command:
        """The last command."""
        return self.heard[-1][1]


@contextmanager
def plain_body(contract: PolicyContract, port: int) -> Iterator[PlainBody]:
    """A body on the bus, 50 retinas a second."""
    body, ended = PlainBody(), threading.Event()
    with Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as bus:
        bus.subscribe([COMMAND, OVERRUN, STATUS], body.hear)
        bus.announce(BODY_NODE)
        show = _shower(bus, body, contract)
        thread = threading.Thread(target=lambda: _repeat(show, ended))
        thread.start()
        try:
            yield body
        finally:
            ended.set()
            thread.join()


def _shower(bus: Bus, body: PlainBody, contract: PolicyContract) -> Callable[[], None]:
    retinas, spec = bus.publisher(RETINA), contract.retina

    def show() -> None:
        now_ns = time.monotonic_ns()
        retina = np.full(spec.shape, body.intensity, np.uint8)
        retinas.put(encode_retina(retina, spec, now_ns), now_ns)

    return show


def _repeat(show: Callable[[], None], ended: threading.Event) -> None:
    while not ended.wait(0.02):
        show()
