"""A sensor and a body on our bus; the brain between them is `reflexarc run`."""

import time

import numpy as np
from roles import PICTURE, RETINA, Body, options, send_retinas

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.messages import topics
from reflexarc_runtime.messages.codec import decode_command, encode_retina
from reflexarc_runtime.messages.wire import Message

SPEC = RetinaSpec()


class CommandTaker:
    """Notes each command as a body hears it."""

    def __init__(self, body: Body) -> None:
        self._body = body

    def hear(self, message: Message) -> None:
        """Take a command; a safe one names no retina, and is a stop."""
        now_ns, command = time.monotonic_ns(), decode_command(message.payload)
        if command is not None:
            self._body.note(now_ns, command.source_time_ns or 0, command.moves)


def main() -> None:
    """Be the role that the command line names, beside our own brain."""
    told = options()
    picture = np.frombuffer(PICTURE, np.uint8).reshape(SPEC.shape)
    with Bus(BusConfig("robot0", told.port, listens=told.role == "body"), time.monotonic_ns) as bus:
        if told.role == "body":
            bus.subscribe([topics.COMMAND], CommandTaker(Body(told.folder)).hear)
            while True:
                time.sleep(60.0)
        retinas = bus.publisher(topics.RETINA)

        def send(payload: bytes) -> None:
            sent_ns = RETINA.unpack(payload)[1]
            retinas.put(encode_retina(picture, SPEC, sent_ns), sent_ns)

        send_retinas(send, told.period_ns)


if __name__ == "__main__":
    main()
