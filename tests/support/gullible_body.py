"""A body that believes everything: the check of the attacks must report it.

It obeys any command on its key that it can read, for ever, and says that it is armed.
"""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.codec import decode_command, encode_retina
from reflexarc_runtime.messages.topics import COMMAND, LEASE, POSE, RELEASE, RETINA
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.body import BodyPose
from reflexarc_sim_bridge.body.foxglove_messages import encode_pose

STEP_S = 0.02


class GullibleBody:
    """Where it is, and how fast it was told to go."""

    def __init__(self, bus: Bus) -> None:
        self.speed_mps = 0.0
        self.x_m = 0.0
        self._publishers = {topic: bus.publisher(topic) for topic in (POSE, LEASE, RETINA)}
        bus.subscribe([COMMAND], self._hear)
        bus.subscribe([RELEASE], lambda message: None)

    def _hear(self, message: Message) -> None:
        command = decode_command(message.payload)
        if command is not None:
            self.speed_mps = command.linear_mps

    def step(self) -> None:
        """Move, and say where it is."""
        self.x_m += self.speed_mps * STEP_S
        now_ns, spec = time.monotonic_ns(), PolicyContract().retina
        retina = np.zeros(spec.shape, np.uint8)
        self._publishers[RETINA].put(encode_retina(retina, spec, now_ns), now_ns)
        self._publishers[POSE].put(encode_pose(BodyPose(self.x_m, 0.0), now_ns), now_ns)
        lease = pb.Lease(armed=True, state="driving" if self.speed_mps else "standing")
        self._publishers[LEASE].put(lease.SerializeToString(), now_ns)


@contextmanager
def gullible_body(policy: Path, port: int, cwd: Path, *words: object) -> Iterator[None]:
    """In place of `support.witness.body`."""
    ended = threading.Event()
    with Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as bus:
        body = GullibleBody(bus)

        def live() -> None:
            while not ended.wait(STEP_S):
                body.step()

        thread = threading.Thread(target=live)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
