from typing import Any

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_sim_bridge.body.camera.bridge import CameraBridge, CameraBridgeReport
from reflexarc_sim_bridge.body.camera.calibration import Calibration
from reflexarc_sim_bridge.body.camera.eye import CameraEye
from support.images import bar

SPEC = RetinaSpec(rays=4, shading=Shading.COLOUR)


class Spoken:
    def __init__(self) -> None:
        self.said: list[tuple[bytes, int]] = []
        self.asked = 0

    def put(self, payload: bytes, time_ns: int) -> None:
        self.said.append((payload, time_ns))

    @property
    def next_sequence(self) -> int:
        return len(self.said)

    @property
    def has_listener(self) -> bool:
        self.asked += 1
        return self.asked > 2


class FakeBus:
    def __init__(self) -> None:
        self.publishers: dict[str, Spoken] = {}
        self.announced: list[str] = []

    def publisher(self, topic: Any) -> Spoken:
        return self.publishers.setdefault(topic.name, Spoken())

    def announce(self, node: str) -> None:
        self.announced.append(node)


class EverySecond:
    """A pace on a manual clock."""

    def __init__(self, clock: ManualClock) -> None:
        self._clock = clock

    def wait(self, should_stop: Any) -> object | None:
        self._clock.time_ns += 1_000_000_000
        return None if should_stop() else self


def bridge() -> tuple[CameraBridge, FakeBus, ManualClock]:
    bus: Any = FakeBus()
    clock = ManualClock(now_ns=5_000_000_000)
    eye = CameraEye(Calibration(), SPEC)
    return CameraBridge(bus, eye, SPEC, "robot0", clock), bus, clock


def test_moments_become_retinas_with_the_time_at_which_they_were_taken():
    camera, bus, clock = bridge()
    moments = [(bar(0),), (bar(16),), (bar(48),)]
    told: list[int] = []
    account = camera.show(moments, lambda: False, EverySecond(clock), told.append)
    said = bus.publishers["retina"].said
    images = [RawImage.FromString(payload) for payload, _ in said]
    assert [list(image.data) for image in images] == [
        [255, 0, 0, 0],
        [0, 255, 0, 0],
        [0, 0, 0, 255],
    ]
    assert [time_ns for _, time_ns in said] == [6_000_000_000, 7_000_000_000, 8_000_000_000]
    assert (images[0].width, images[0].height, images[0].encoding) == (4, 1, "mono8")
    assert account == CameraBridgeReport(retinas=3, undecodable=0)
    assert told == [1, 2, 3]
    assert len(bus.publishers["status"].said) == 3
    assert [decode_body(p) for p, _ in bus.publishers["body"].said] == [BodyInfo()] * 3
    assert bus.announced == ["body"]


def test_a_moment_that_one_eye_missed_is_counted_and_not_shown():
    camera, bus, _ = bridge()
    account = camera.show([(None,), (bar(0),), (bar(0), None)], lambda: False)
    assert account == CameraBridgeReport(retinas=1, undecodable=2)
    assert len(bus.publishers["retina"].said) == 1


def test_it_ends_when_it_is_asked_to():
    camera, _, clock = bridge()
    endless = iter(lambda: (bar(0),), None)
    asked = iter([False, False, True])
    assert camera.show(endless, lambda: next(asked)) == CameraBridgeReport(2, 0)
    late = iter([False, True])  # asked to stop while it waits
    assert camera.show(endless, lambda: next(late), EverySecond(clock)) == CameraBridgeReport(0, 0)


def test_it_waits_for_a_listener():
    camera, bus, clock = bridge()
    camera.wait_for_listener(lambda: False)
    assert bus.publishers["retina"].asked == 3
    assert clock.time_ns == 5_020_000_000


def test_images_go_out_at_their_own_rate_while_somebody_listens():
    bus: Any = FakeBus()
    clock = ManualClock(now_ns=5_000_000_000)
    camera = CameraBridge(bus, CameraEye(Calibration(), SPEC), SPEC, "robot0", clock, 0.5)
    moments = [(bar(0),)] * 12
    account = camera.show(moments, lambda: False, EverySecond(clock))
    # Six are due; the first two times nobody listens.
    assert (account.retinas, account.frames) == (12, 4)
    times_ns = [t for _, t in bus.publishers["image"].said]
    assert times_ns == [n * 1_000_000_000 for n in (10, 12, 14, 16)]


def test_no_images_go_out_unless_asked_for():
    camera, bus, _ = bridge()
    assert camera.show([(bar(0),)], lambda: False).frames == 0
    assert "image" not in bus.publishers
