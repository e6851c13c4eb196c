"""Unusable messages: the bytes, attachments and encodings of a broken sender."""

from dataclasses import dataclass

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_runtime.messages.wire import MAX_PAYLOAD_BYTES, Stamp, pack_stamp, protobuf_encoding
from reflexarc_sim_bridge.body.faults.script import Malformation

HUGE_ATTACHMENT_BYTES = 100_000
_ALMOST_TOO_LARGE = MAX_PAYLOAD_BYTES - 4096


@dataclass(frozen=True, slots=True)
class MessageParts:
    """What a message on the bus is made of."""

    payload: bytes
    attachment: bytes
    encoding: str


def malformed(parts: MessageParts, how: Malformation) -> MessageParts:
    """A good retina, damaged in one way, so that no receiver can use it."""
    payload, attachment, encoding = parts.payload, parts.attachment, parts.encoding
    match how:
        case Malformation.NO_ATTACHMENT:
            attachment = b""
        case Malformation.SHORT_ATTACHMENT:
            attachment = attachment[:-1]
        case Malformation.HUGE_ATTACHMENT:
            attachment = bytes(HUGE_ATTACHMENT_BYTES)
        case Malformation.NEGATIVE_STAMP:
            attachment = pack_stamp(Stamp(-1, -1))
        case Malformation.WRONG_ENCODING:
            encoding = protobuf_encoding("foxglove.LaserScan")
        case _:
            payload = _payload(payload, how)
    return MessageParts(payload, attachment, encoding)


def _payload(payload: bytes, how: Malformation) -> bytes:
    match how:
        case Malformation.NOT_PROTOBUF:
            return b"\xff" * len(payload)
        case Malformation.EMPTY:
            return b""
        case Malformation.TRUNCATED:
            return payload[: len(payload) // 2]  # the picture lies in the second half
        case Malformation.HUGE_PAYLOAD:
            return bytes(2 * MAX_PAYLOAD_BYTES)
        case _:
            return _image(RawImage.FromString(payload), how).SerializeToString()


def _image(image: RawImage, how: Malformation) -> RawImage:
    match how:
        case Malformation.WRONG_SIZE:
            image.width += 1
            image.data = image.data + b"\x00"
        case Malformation.WRONG_PIXELS:
            image.encoding = "16UC1"
        case Malformation.HUGE_TEXT:
            image.encoding = "x" * _ALMOST_TOO_LARGE
        case _:
            image.encoding = "rgb8" if image.encoding == "mono8" else "mono8"
            image.data = image.data * 3
    return image
