"""Lidar logs, images and logs with poses that were made to harm."""

import gzip
import math
import struct
import zlib
from pathlib import Path

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from hostile.measured import Maker
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from support.lidar import coreslam, flaser
from support.policies import exported
from support.rewriting import rewrite
from support.round_room import turning_log

_GIBIBYTE = 1 << 30
_PIECE = 1 << 24


def _lidar(name: str, content: bytes, kind: str = "carmen") -> Maker:
    def made(folder: Path) -> tuple[Path, list[list[str]]]:
        path = folder / name
        path.write_bytes(content)
        return path, [["import", kind, "FILE", "-o", "OUT.mcap"]]

    return made


def _packed(begin: bytes, filler: bytes, size: int) -> Maker:
    """A small gzip file that is large when it is unpacked."""

    def made(folder: Path) -> tuple[Path, list[list[str]]]:
        path, piece = folder / "bomb.log.gz", filler * (_PIECE // len(filler))
        with gzip.open(path, "wb", compresslevel=6) as file:
            file.write(begin)
            for _ in range(size // len(piece)):
                file.write(piece)
        return path, [["import", kind, "FILE", "-o", "OUT.mcap"] for kind in ("carmen", "coreslam")]

    return made


def _endless_line(folder: Path) -> tuple[Path, list[list[str]]]:
    path = folder / "line.log"
    with path.open("wb") as file:
        file.write(b"FLASER 181 ")
        for _ in range(_GIBIBYTE // _PIECE):
            file.write(b"1.5 " * (_PIECE // 4))
    return path, [["import", kind, "FILE", "-o", "OUT.mcap"] for kind in ("carmen", "coreslam")]


def _device(folder: Path) -> tuple[Path, list[list[str]]]:
    path = folder / "zero.log"
    path.symlink_to("/dev/zero")
    return path, [["import", "carmen", "FILE", "-o", "OUT.mcap"]]


def _extreme(count: str) -> bytes:
    """Scans with numbers that are hardly any."""
    words = ("1e999", "-1e999", "nan", "1e-320", "9" * 400, "0x10", "1_0", "١")
    lines = [flaser(" ".join(words)), flaser(pose="1e308 1e308 1e308"), flaser(time="1e999")]
    lines += [flaser(time="9" * 400), flaser(time="1e-999999999999"), flaser(pose="nan 1e999 0")]
    lines += [f"FLASER {count} 1 2 3\n", f"ROBOTLASER1 0 1e999 nan -1 -1 0 0 {count} 1 2\n"]
    lines += ["PARAM laser_front_laser_fov 1e-320 x 0\n", "ODOM 1e999 nan x\n", flaser()]
    return "".join(lines).encode()


def _png(width: int, height: int, data: bytes, depth: int = 8) -> bytes:
    """A PNG that says its size, whatever its data holds."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    header = struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0)
    whole = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + whole


def _image(name: str, content: bytes) -> Maker:
    def made(folder: Path) -> tuple[Path, list[list[str]]]:
        path = folder / name
        path.write_bytes(content)
        eye = RetinaSpec(rays=16, shading=Shading.COLOUR)
        (folder / "policy.onnx").write_bytes(exported(PolicyContract(retina=eye)))
        return path, [["camera", "FILE", "--policy", f"{folder / 'policy.onnx'}", "--rate", "10"]]

    return made


def _bomb_png(folder: Path) -> tuple[Path, list[list[str]]]:
    side = 20_000
    row = b"\0" * (1 + 3 * side)
    return _image("bomb.png", _png(side, side, row * side))(folder)


def _posed(value: float) -> Maker:
    """A log whose poses are at a place that is none."""

    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        if not topic.endswith("/pose"):
            return payload
        pose = PoseInFrame.FromString(payload)
        pose.pose.position.x = value
        return pose.SerializeToString()

    def made(folder: Path) -> tuple[Path, list[list[str]]]:
        plain = turning_log(folder / "plain.mcap")
        path = rewrite(plain, folder / "posed.mcap", edit)
        return path, [["render", "FILE", "-o", f"OUT.{kind}"] for kind in ("png", "gif")]

    return made


_POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 99\n"
_LARGE = (2**31 - 1, 2**31 - 1)

FILES: dict[str, Maker] = {
    "a gzip of newlines": _packed(b"", b"\n", 4 * _GIBIBYTE),
    "a gzip of one line": _packed(b"", b"x", 4 * _GIBIBYTE),
    "a gzip of zeros": _packed(b"FLASER", b"\0", 4 * _GIBIBYTE),
    "a gzip of the same scan": _packed(b"", flaser("1.5 " * 180).encode(), _GIBIBYTE),
    "a gzip in which one scan comes first": _packed(flaser().encode(), b"ODOM 1\n", _GIBIBYTE),
    "a line of a gibibyte": _endless_line,
    "numbers that are hardly any": _lidar("extreme.log", _extreme("9" * 4000)),
    "half a million unknown keywords": _lidar(
        "words.log", b"".join(b"K%d 1\n" % k for k in range(500_000))
    ),
    "half a million blank lines": _lidar("blank.log", b"\r\n" * 500_000, "coreslam"),
    "65,536 beams": _lidar("beams.log", flaser("1 " * 65_536).encode() * 20),
    "a coreslam time of 10^(10^9)": _lidar(
        "time.dat", coreslam([300] * 682, "1e1000000000").encode(), "coreslam"
    ),
    "a device without end": _device,
    "a lidar log that is a pointer of Git LFS": _lidar("lfs.log", _POINTER),
    "a PNG that says 2^31 pixels a side": _image("large.png", _png(*_LARGE, b"\0" * 99)),
    "a PNG of 20,000 pixels a side": _bomb_png,
    "a PGM that says 10^9 pixels a side": _image("large.pgm", b"P5 1000000000 1000000000 255\n00"),
    "an image that is a pointer of Git LFS": _image("lfs.png", _POINTER),
    "poses that are no number": _posed(math.nan),
    "poses without end": _posed(math.inf),
    "poses at 1e300 m": _posed(1e300),
}
