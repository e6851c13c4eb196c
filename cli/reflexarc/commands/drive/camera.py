"""`reflexarc camera`: a camera, a video or images become the retinas of a body."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from reflexarc.terminal.output import aside, console, facts, plain, print_json, progress_bar
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining, contract_of
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_sim_bridge.body.camera.bridge import CameraBridgeReport, Moment
    from reflexarc_sim_bridge.body.camera.calibration import Calibration
    from reflexarc_sim_bridge.body.camera.sources import ImageSource

MAX_RATE_HZ = 1000.0
MAX_NOTICES = 10


@dataclass(frozen=True)
class CameraCommand:
    """Publish retinas from a real camera, a video or images. It moves nothing.

    The policy must have been trained on colours (reflexarc train --preset paper). Which rows count,
    how wide the lens is and which colours are obstacles stand in a calibration. For two eyes give
    two sources, or one with both images side by side.

    Examples:
      reflexarc camera 0 --calibration camera.toml
      reflexarc camera drive.avi --policy runs/paper/policy.onnx
      reflexarc camera 0 --right 1
      reflexarc camera "frames/*.png" --rate 10
      reflexarc camera 0 --frames-hz 5
      reflexarc camera deep/ --bits 12
      reflexarc camera 0 --policy racer.onnx --max-speed-mps 30
    """

    source: tyro.conf.Positional[str]
    """A camera's number or path, a video, an image, a folder of images, or a glob of them."""
    right: str | None = None
    """The right eye's source; `source` is then the left one's."""
    calibration: Path | None = None
    """Rows, lens and colours (TOML); by default the middle rows, spread, on black."""
    policy: Path | None = None
    """Build the eye from this policy; by default, ask the runtime on the bus."""
    rate: float | None = None
    """Images a second; by default the video's own, or the contract's. A camera may give another."""
    frames_hz: float = 0.0
    """Publish so many of the images a second as well, at most, on <robot>/image (JPEG), for whoever
    records or looks. 0: none."""
    bits: int | None = None
    """Bits that the camera gives in images of 16 bits; by default the images must show it."""
    bounds: Bounds = field(default_factory=Bounds)
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Show images until the end, then say how many."""
        from reflexarc_runtime.messages.topics import BODY_NODE

        if self.rate is not None and not 0.0 < self.rate <= MAX_RATE_HZ:
            raise UsageError(f"--rate: expected 0 to {MAX_RATE_HZ:g} Hz, got {self.rate}")
        if not 0.0 <= self.frames_hz <= MAX_RATE_HZ:
            raise UsageError(f"--frames-hz: expected 0 to {MAX_RATE_HZ:g} Hz, got {self.frames_hz}")
        if self.bits is not None and not 9 <= self.bits <= 16:
            raise UsageError(f"--bits: expected 9 to 16, got {self.bits}")
        sources, calibration = self._sources(), self._calibration()
        with (
            StopFlag() as stop,
            self.joining.bus_in_time(BODY_NODE, stop, "reflexarc camera", listens=True) as bus,
        ):
            contract = contract_of(self.policy, bus, stop, "reflexarc camera", self.bounds)
            account = self._show(bus, sources, calibration, contract, stop) if contract else None
        if account is not None:
            self._tell(account)
        return 0

    def _sources(self) -> "tuple[ImageSource, ...]":
        # FFmpeg within OpenCV would tell standard error about every flaw of a file.
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
        from reflexarc_sim_bridge.body.camera.sources import source_named

        names = (self.source,) if self.right is None else (self.source, self.right)
        notices = _Notices()
        sources = tuple(source_named(name, self.rate, self.bits, notices.say) for name in names)
        _check_pairs(sources)
        return sources

    def _calibration(self) -> "Calibration":
        from reflexarc_sim_bridge.body.camera.calibration import Calibration, read_calibration

        return Calibration() if self.calibration is None else read_calibration(self.calibration)

    def _show(
        self,
        bus: "Bus",
        sources: "tuple[ImageSource, ...]",
        calibration: "Calibration",
        contract: "PolicyContract",
        stop: StopFlag,
    ) -> "CameraBridgeReport":
        from reflexarc.wiring.waiting import Waiting, Wish
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.inbox import Inbox
        from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
        from reflexarc_runtime.messages.topics import RETINA
        from reflexarc_sim_bridge.body.camera.bridge import CameraBridge
        from reflexarc_sim_bridge.body.camera.eye import CameraEye

        if len(sources) > contract.retina.eyes:
            raise UsageError("--right: expected a policy with two eyes, got one with one")
        eye, clock = CameraEye(calibration, contract.retina), MonotonicClock()
        robot, frames_hz = self.joining.robot, self.frames_hz
        bridge = CameraBridge(bus, eye, contract.retina, robot, clock, frames_hz)
        moments: Iterable[Moment] = zip(*(source.frames() for source in sources), strict=False)
        totals = [source.total for source in sources if source.total is not None]
        aside.print(f"reflexarc camera: {plain(self.source)}, {contract.retina.rays} rays")
        if len(totals) < len(sources):  # a camera among them paces by itself
            return bridge.show(moments, stop)
        rate_hz = self.rate or sources[0].rate_hz or contract.rate_hz
        wish = Wish("reflexarc camera", "a runtime", RETINA.key(bus.robot), ("*/tick",))
        with Waiting(bus, wish, lambda: bridge.has_listener):
            bridge.wait_for_listener(stop)
        with _progress(min(totals)) as progress:
            return bridge.show(moments, stop, RatePacer(rate_hz, clock, Inbox()), progress)

    def _tell(self, account: "CameraBridgeReport") -> None:
        if account.undecodable and not account.retinas:
            raise UsageError(
                f"{plain(self.source)}: expected images, got {account.undecodable} "
                "of which none could be read"
            )
        if self.json:
            print_json(account)
            return
        shown = {"retinas": account.retinas, "not decoded": account.undecodable}
        frames = {"images": account.frames} if self.frames_hz else {}
        console.print(facts({**shown, **frames}))


class _Notices:
    """Says what happens to single images, as long as a person would read it."""

    def __init__(self) -> None:
        self._left = MAX_NOTICES

    def say(self, line: str) -> None:
        """One line on standard error; nothing after too many."""
        if self._left > 0:
            aside.print(plain(line), soft_wrap=True)
        if self._left == 0:
            aside.print("further such lines are left out; the end counts the images")
        self._left -= 1


def _check_pairs(sources: "tuple[ImageSource, ...]") -> None:
    """Two eyes' image files must be pairs: where one is missing, all later ones are mixed up."""
    from reflexarc_sim_bridge.body.camera.image_files import Images

    totals = [source.total for source in sources if isinstance(source, Images)]
    if len(set(totals)) > 1:
        raise UsageError(f"--right: expected {totals[0]} images as on the left, got {totals[1]}")


@contextmanager
def _progress(total: int) -> "Iterator[Callable[[int], None]]":
    with progress_bar("images", total) as progress:
        yield lambda done: progress(done, total)
