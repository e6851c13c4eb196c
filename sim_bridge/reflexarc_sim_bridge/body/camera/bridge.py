"""The bridge between a camera and the bus: it publishes retinas and takes no commands."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.loop.throttle import Throttle
from reflexarc_runtime.messages.body_info import BodyInfo, encode_body
from reflexarc_runtime.messages.codec import Status, encode_retina, encode_status
from reflexarc_runtime.messages.topics import BODY, BODY_NODE, IMAGE, RETINA, STATUS
from reflexarc_sim_bridge.body.camera.eye import CameraEye, Image
from reflexarc_sim_bridge.body.camera.frames import FramePace, encode_frame

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

_POLL_NS = 10_000_000

Moment = tuple[Image | None, ...]
"""One image for each eye, taken at one moment; None where one cannot be decoded."""


class MomentPace(Protocol):
    """Decides when the next image is published."""

    def wait(self, should_stop: Callable[[], bool]) -> object | None:
        """Wait; None when asked to stop meanwhile."""
        ...


@dataclass(frozen=True, slots=True)
class CameraBridgeReport:
    """How many images were published, or could not be."""

    retinas: int
    undecodable: int
    frames: int = 0
    """Images published beside the retinas."""


class CameraBridge:
    """Publishes what a camera sees.

    Args:
        bus: an open session.
        eye: makes retinas of images.
        spec: what the policy sees.
        robot: whose camera it is.
        clock: source time of the retinas.
        frames_hz: how many of the images a second are published as well, at most; 0: none.
    """

    def __init__(
        self,
        bus: "Bus",
        eye: CameraEye,
        spec: RetinaSpec,
        robot: str,
        clock: Clock,
        frames_hz: float = 0.0,
    ) -> None:
        self._retinas = bus.publisher(RETINA)
        self._status, self._info = bus.publisher(STATUS), bus.publisher(BODY)
        self._images = bus.publisher(IMAGE) if frames_hz else None
        self._frames = FramePace(frames_hz) if frames_hz else None
        self._frames_shown = 0
        self._every_second = Throttle()
        self._eye = eye
        self._spec = spec
        self._robot = robot
        self._clock = clock
        bus.announce(BODY_NODE)

    @property
    def has_listener(self) -> bool:
        """Whether anyone listens to the retinas."""
        return self._retinas.has_listener

    def wait_for_listener(self, should_stop: Callable[[], bool]) -> None:
        """Wait for a subscriber: the images of a file are published only once."""
        while not self.has_listener and not should_stop():
            self._clock.sleep_until_ns(self._clock.now_ns() + _POLL_NS)

    def show(
        self,
        moments: Iterable[Moment],
        should_stop: Callable[[], bool],
        pace: MomentPace | None = None,
        progress: Callable[[int], None] = lambda done: None,
    ) -> CameraBridgeReport:
        """Publish one moment after another.

        Args:
            moments: the images.
            should_stop: asked between two moments.
            pace: when each is due; without one, at once.
            progress: called with the number of moments so far.
        """
        retinas = undecodable = 0
        for images in moments:
            if should_stop() or (pace is not None and pace.wait(should_stop) is None):
                break
            seen = tuple(image for image in images if image is not None)
            if len(seen) == len(images):
                self._show(seen)
                retinas += 1
            else:
                undecodable += 1
            progress(retinas + undecodable)
        return CameraBridgeReport(retinas, undecodable, self._frames_shown)

    def _show(self, images: tuple[Image, ...]) -> None:
        # The time of exposure is unknown here; that of arrival is the nearest one.
        now_ns = self._clock.now_ns()
        payload = encode_retina(self._eye.look(images), self._spec, now_ns)
        self._retinas.put(payload, now_ns)
        self._show_frame(images, now_ns)
        self._say_every_second(now_ns)

    def _show_frame(self, images: tuple[Image, ...], now_ns: int) -> None:
        """Publish the images themselves; behind the retina, which somebody waits for."""
        if self._images is None or self._frames is None:
            return
        if self._frames.is_due(now_ns) and self._images.has_listener:
            self._images.put(encode_frame(images, self._robot, now_ns), now_ns)
            self._frames_shown += 1

    def _say_every_second(self, now_ns: int) -> None:
        if not self._every_second.is_due(now_ns):
            return
        status = Status(node=BODY_NODE, ticks=self._retinas.next_sequence)
        self._status.put(encode_status(status), now_ns)
        self._info.put(encode_body(BodyInfo()), now_ns)
