"""Sensor messages as a body would send them."""

import numpy as np

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding

MS = 1_000_000
SPEC = RetinaSpec(rays=4)
KEY = "robot0/retina"
ENCODING = protobuf_encoding("foxglove.RawImage")


def retina_message(
    sequence: int,
    received_ns: int,
    *,
    value: int = 7,
    source_ns: int | None = None,
    spec: RetinaSpec = SPEC,
) -> Message:
    """A good retina, every ray of `value`."""
    source = received_ns if source_ns is None else source_ns
    payload = encode_retina(np.full(spec.shape, value, np.uint8), spec, source)
    return Message(KEY, payload, ENCODING, pack_stamp(Stamp(sequence, source)), received_ns)
