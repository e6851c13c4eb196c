"""Pictures of ROS 2 as Foxglove's: the pixels and the bytes stay as they are.

`sensor_msgs/Image` becomes `foxglove.RawImage` under the same name of its encoding;
`sensor_msgs/CompressedImage` becomes `foxglove.CompressedImage`. What a viewer could only show
wrongly is refused: pixels of two bytes in the other order, an image that is not as large as it
says, a depth image that hides in a PNG.
"""

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_runtime.messages.codec import timestamp
from reflexarc_runtime.ros2.cdr import UnusableMessageError, read_cdr, stamp_ns
from reflexarc_runtime.ros2.ros_types import COMPRESSED_IMAGE, IMAGE

MAX_IMAGE_BYTES = 1 << 28
"""Of one image in a file: far more than any camera sends."""

_ONE_BYTE = ("8", "8UC1", "8UC3", "8UC4")
"""How the names of encodings end whose pixels need no order of bytes: `rgb8`, `mono8`, `8UC3`."""
_FORMATS = (("jpeg", "jpeg"), ("jpg", "jpeg"), ("png", "png"), ("webp", "webp"))


def decode_image(payload: bytes) -> RawImage:
    """Read `sensor_msgs/Image`.

    Raises:
        UnusableMessageError: it is none, or cannot be shown as it is.
    """
    image = read_cdr(payload, IMAGE, MAX_IMAGE_BYTES)
    if image.height * image.step != len(image.data) or image.step < image.width:
        raise UnusableMessageError("an image that is not as large as it says")
    if image.is_bigendian and not image.encoding.endswith(_ONE_BYTE):
        raise UnusableMessageError("pixels with their high byte first")
    return RawImage(
        timestamp=timestamp(stamp_ns(image.header)),
        frame_id=image.header.frame_id,
        width=image.width,
        height=image.height,
        encoding=image.encoding,
        step=image.step,
        data=image.data.tobytes(),
    )


def decode_compressed(payload: bytes) -> CompressedImage:
    """Read `sensor_msgs/CompressedImage`.

    Raises:
        UnusableMessageError: it is none, or no viewer knows its format.
    """
    image = read_cdr(payload, COMPRESSED_IMAGE, MAX_IMAGE_BYTES)
    return CompressedImage(
        timestamp=timestamp(stamp_ns(image.header)),
        frame_id=image.header.frame_id,
        data=image.data.tobytes(),
        format=_format(image.format),
    )


def _format(words: str) -> str:
    """What a format is called; image_transport writes `rgb8; jpeg compressed bgr8`."""
    lower = words.lower()
    if "compresseddepth" not in lower:
        for part, name in _FORMATS:
            if part in lower:
                return name
    raise UnusableMessageError("an image in a format that no viewer knows")
