"""Scans as some driver of some scanner on some robot would send them, drawn by Hypothesis."""

import math
import random
from dataclasses import dataclass

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from hypothesis import strategies as st

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.ros2.laser_scan import RosScanner, decode_scan, encode_scan
from reflexarc_runtime.sensing.mounting import Mount, Sector, pose_of
from reflexarc_runtime.sensing.range_meaning import Angles, RangeMeaning
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_runtime.sensing.scan_reading import read_scan
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from support.ros2 import laser_scan
from support.slow_scans import NOTHING, TOO_NEAR, UNKNOWN, Told

CONSTANT_M = 8.19
MIN_M = 0.1
BELOW_M = 0.04
"""Where something is that is too near to be measured, if the driver says a number."""

COUNTS = (2, 3, 8, 17, 45, 45, 90, 90, 181, 181, 181, 360, 361, 1440)
SPANS_RAD = tuple(map(math.radians, (90, 180, 180, 240, 270, 350, 359, 360, 360, 365, 378)))


@dataclass(frozen=True)
class Driver:
    """How a driver writes what a scanner measures, and how it is told to the runtime."""

    wire: str
    """ros or foxglove."""
    nothing: str
    too_near: str
    unknown: str
    limits: str
    """Whether the message's limits are right, or flags say them."""
    max_m: float
    degrees: bool
    clockwise: bool
    says_pose: bool

    @property
    def meaning(self) -> RangeMeaning:
        """The flags that say what this driver means."""
        words = {"nan": ("nan",), "zero": ("zero",), "constant": (f"{CONSTANT_M}",)}
        by_flags = self.limits == "flags"
        return RangeMeaning(
            words.get(self.nothing, ()),
            MIN_M if by_flags else None,
            self.max_m if by_flags else None,
            Angles.DEGREES if self.degrees else Angles.RADIANS,
        )

    @property
    def top_m(self) -> float:
        """Nothing that this driver measures is farther away."""
        farthest_m = CONSTANT_M if self.nothing == "constant" else math.inf
        return 0.99 * min(farthest_m, self.max_m)

    def word(self, told: Told) -> float:
        """What it writes for a beam."""
        if not isinstance(told, str):
            return told
        kind = {NOTHING: self.nothing, TOO_NEAR: self.too_near, UNKNOWN: self.unknown}[told]
        return {
            "inf": math.inf,
            "-inf": -math.inf,
            "nan": math.nan,
            "zero": 0.0,
            "negative": -1.0,
            "below": BELOW_M,
            "constant": CONSTANT_M,
            "max": self.max_m,
            "beyond": self.max_m + 1.0,
        }[kind]


@dataclass(frozen=True)
class Drawn:
    """A scan, in truth."""

    driver: Driver
    start_rad: float
    step_rad: float
    told: tuple[Told, ...]
    mount: Mount
    ignored: tuple[Sector, ...]
    spec: RetinaSpec

    @property
    def angles_rad(self) -> list[float]:
        """Of each beam, in the scanner's frame."""
        return [self.start_rad + self.step_rad * beam for beam in range(len(self.told))]

    def sent(self) -> Scan:
        """What the runtime reads of it.

        Raises:
            UnusableMessageError: the bridge refuses it.
            UnusableScanError: the runtime does.
        """
        ranges_m = [self.driver.word(told) for told in self.told]
        if self.driver.wire == "ros":
            scanner = RosScanner(self.driver.meaning, self.mount, self.ignored)
            sent = LaserScan.FromString(encode_scan(decode_scan(self._ros(ranges_m), scanner)))
            return read_scan(sent, SenseSettings())
        sent = LaserScan(ranges=ranges_m)
        sent.start_angle = self._unit(self.start_rad)
        sent.end_angle = self._unit(self.angles_rad[-1])
        mount = None if self.driver.says_pose else self.mount
        if self.driver.says_pose:
            sent.pose.CopyFrom(pose_of(self.mount))
        return read_scan(
            LaserScan.FromString(sent.SerializeToString()),
            SenseSettings(mount=mount, ignored=self.ignored, meaning=self.driver.meaning),
        )

    def _ros(self, ranges_m: list[float]) -> bytes:
        limits_m = (MIN_M, self.driver.max_m)
        if self.driver.limits == "flags":
            limits_m = (0.0, 0.0)
        scan = laser_scan(
            ranges_m,
            start_rad=self._unit(self.start_rad),
            step_rad=self._unit(self.step_rad),
            limits_m=limits_m,
        )
        return bytes(scan.serialize())

    def _unit(self, angle_rad: float) -> float:
        return math.degrees(angle_rad) if self.driver.degrees else angle_rad


def single(number: float) -> float:
    """A number as a message of single precision carries it."""
    return float(np.float32(number))


@st.composite
def drivers(draw: st.DrawFn) -> Driver:
    """Of any convention."""
    wire = draw(st.sampled_from(("ros", "foxglove")))
    limits = draw(st.sampled_from(("message", "flags")))
    with_limits = wire == "ros" or limits == "flags"
    words = ["inf", "nan", "zero", "constant", *(["max"] if with_limits else [])]
    if wire == "ros" and limits == "message":
        words.append("beyond")
    nothing = draw(st.sampled_from(words))
    unknowns = [word for word in ("nan", "zero", "negative") if word != nothing]
    return Driver(
        wire,
        nothing,
        draw(st.sampled_from(("-inf", "below") if with_limits else ("-inf",))),
        draw(st.sampled_from(unknowns)),
        limits,
        draw(st.sampled_from((12.0, 5.6, 3.5, 25.0))) if with_limits else 25.0,
        draw(st.sampled_from((False, False, True))),
        draw(st.booleans()) if wire == "ros" else False,
        draw(st.booleans()),
    )


eyes = st.builds(
    RetinaSpec,
    rays=st.sampled_from((16, 16, 1, 2, 5, 45)),
    fov_rad=st.sampled_from((math.pi, math.pi, 2 * math.pi, 3.0, 1.5, 1.5 * math.pi)),
    range_m=st.sampled_from((5.0, 1.5, 12.0)),
    shading=st.sampled_from(Shading),
    samples=st.sampled_from((1, 1, 3)),
    beams=st.sampled_from(
        (BeamRule.SECTOR_MINIMUM, BeamRule.SECTOR_MINIMUM, BeamRule.NEAREST_BEAM)
    ),
)
yaws_rad = st.one_of(
    st.sampled_from((0.0, math.pi, -math.pi / 2, math.pi / 180)), st.floats(-7.0, 7.0)
)
shifts_m = st.sampled_from((0.0, 0.0, 0.2, -0.15, 0.35))
mounts = st.builds(Mount, shifts_m, shifts_m, yaws_rad, st.booleans())
sectors = st.builds(
    lambda right, width: Sector(math.radians(right), math.radians(right + width)),
    st.sampled_from((-180, -170, 120, 170, 350, -10)),
    st.sampled_from((0, 5, 40)),
)


@st.composite
def told_by(draw: st.DrawFn, count: int, top_m: float) -> tuple[Told, ...]:
    """What the beams meet: a background, and some things before it."""
    background = draw(st.sampled_from((NOTHING, "random", top_m, "random", NOTHING, UNKNOWN)))
    told: list[Told] = [background] * count
    if background == "random":
        chance = random.Random(draw(st.integers(0, 99)))
        words = (NOTHING, UNKNOWN, TOO_NEAR)
        told = [
            single(chance.uniform(0.15, top_m)) if chance.random() < 0.9 else chance.choice(words)
            for _ in range(count)
        ]
    distances = st.floats(0.15625, top_m, width=32, exclude_max=True)
    what = st.one_of(st.sampled_from((UNKNOWN, TOO_NEAR, NOTHING)), distances)
    for place, width, thing in draw(
        st.lists(st.tuples(st.floats(0, 1), st.sampled_from((1, 1, 2, 9, 40)), what), max_size=5)
    ):
        first = int(place * (count - 1))
        for beam in range(first, min(first + width, count)):
            told[beam] = thing
    return tuple(told)


@st.composite
def scans(draw: st.DrawFn) -> Drawn:
    """A scan in any convention, of any scanner on any robot, for any eye."""
    driver, count = draw(drivers()), draw(st.sampled_from(COUNTS))
    span_rad = draw(st.sampled_from(SPANS_RAD))
    is_open = draw(st.booleans())  # whether the last beam is a step before the end
    step_rad = span_rad / (count if is_open else count - 1)
    start_rad = draw(
        st.sampled_from((-span_rad / 2, -span_rad / 2, -math.pi, 0.0, 0.01 - span_rad / 2))
    )
    if driver.clockwise:
        start_rad, step_rad = -start_rad, -step_rad
    if driver.wire == "ros":
        start_rad, step_rad = _as_sent(start_rad, driver), _as_sent(step_rad, driver)
    told = draw(told_by(count, single(driver.top_m)))
    ignored = tuple(draw(st.lists(sectors, max_size=1)))
    return Drawn(driver, start_rad, step_rad, told, draw(mounts), ignored, draw(eyes))


def _as_sent(angle_rad: float, driver: Driver) -> float:
    """An angle as the message of single precision says it."""
    if driver.degrees:
        return math.radians(single(math.degrees(angle_rad)))
    return single(angle_rad)
