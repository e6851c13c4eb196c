"""The good files that mutants are made of, and the ways in which the commands use them."""

import gzip
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_sim_bridge.worlds.files import world_text
from support.flip_judge import without_checks
from support.images import bar
from support.lidar import coreslam, flaser, odom
from support.policies import SMALL, exported
from support.recordings import CONTRACT, drive, nominal
from support.round_room import turning_log

_TICKS = 40


@dataclass(frozen=True)
class Good:
    """A file that is as it should be."""

    name: str
    data: bytes
    ways: tuple[str, ...]
    """Words of a command; or `live`, `look`: what a command does with a file, without its bus."""
    is_text: bool = False


def _log(folder: Path) -> Good:
    path = folder / "good-log"
    drive(path, exported(CONTRACT), nominal(_TICKS), _TICKS)
    return Good("ours.mcap", path.read_bytes(), _LOG)


def _bare_log(folder: Path) -> Good:
    """Without a CRC, and not packed: what is changed reaches whoever reads it."""
    drive(folder / "whole", exported(CONTRACT), nominal(_TICKS), _TICKS)
    data = without_checks(folder / "whole", folder / "good-bare").read_bytes()
    return Good("bare.mcap", data, _LOG)


def _seen_log(folder: Path) -> Good:
    """Of scans and poses, without checks, as `render` draws it."""
    data = without_checks(turning_log(folder / "turning"), folder / "seen").read_bytes()
    return Good("seen.mcap", data, ("render FILE -o OUT.png", "info FILE", "cut FILE -o OUT.mcap"))


def _policy(folder: Path) -> Good:
    (folder / "replayed").mkdir(exist_ok=True)
    log = folder / "replayed" / "log.mcap"
    drive(log, exported(CONTRACT), nominal(_TICKS), _TICKS)
    return Good("policy.onnx", exported(CONTRACT, 1), ("info FILE", f"replay {log} --policy FILE"))


def _small_policy(folder: Path) -> Good:
    ways = ("info FILE", "info FILE", "info FILE", "info FILE --backend onnxruntime")
    return Good("small.onnx", exported(SMALL), ways)


def _wide_policy(folder: Path) -> Good:
    eye = RetinaSpec(rays=32, frames=2)
    return Good("wide.onnx", exported(PolicyContract(retina=eye)), ("info FILE",))


def _world(name: str) -> Callable[[Path], Good]:
    ways = ("worlds show FILE", "live FILE", "live FILE")
    return lambda _: Good(f"{name}.toml", world_text(name).encode(), ways, is_text=True)


def _carmen_text() -> bytes:
    lines = [flaser("1.5 " * 181, time=str(1.0 + 0.1 * n)) for n in range(20)]
    return "".join(["PARAM laser_front_laser_fov 180\n", odom("0 0 0", "1.0"), *lines]).encode()


def _carmen(_: Path) -> Good:
    return Good("carmen.log", _carmen_text(), _CARMEN, is_text=True)


def _packed_carmen(_: Path) -> Good:
    return Good("carmen.log.gz", gzip.compress(_carmen_text(), mtime=0), _CARMEN)


def _coreslam(_: Path) -> Good:
    text = "".join(coreslam([300] * 682, 1_000_000 + 100_000 * n) for n in range(10))
    return Good("core.dat", text.encode(), ("import coreslam FILE -o OUT.mcap",), is_text=True)


def _image(kind: str) -> Callable[[Path], Good]:
    def made(_: Path) -> Good:
        image = bar(10)[:, :, 0] if kind == "pgm" else bar(10)
        right, data = cv2.imencode(f".{kind}", np.ascontiguousarray(image))
        assert right
        return Good(f"image.{kind}", data.tobytes(), ("look FILE",))

    return made


_LOG = ("info FILE", "replay FILE", "replay FILE", "recover FILE -o OUT.mcap")
_CARMEN = ("import carmen FILE -o OUT.mcap",)
MAKERS: tuple[Callable[[Path], Good], ...] = (
    *(_log, _bare_log, _seen_log, _policy, _small_policy, _wide_policy),
    *(_world("reference-1"), _world("crossing"), _world("gates")),
    *(_carmen, _packed_carmen, _coreslam),
    *(_image("png"), _image("jpg"), _image("pgm")),
)


def good_files(folder: Path) -> list[Good]:
    """All of them; made in a folder that is empty."""
    return [make(folder) for make in MAKERS]
