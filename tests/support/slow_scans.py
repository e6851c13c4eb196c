"""What an eye may show of a scan, from `docs/senses.md`, beam by beam in plain Python.

The beams are told as they are, not as a driver writes them: a distance, or one of three words.
Near the border of a sector rounding may put a beam on either side: what lies surely inside must be
shown, what lies perhaps inside may be.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.sensing.mounting import Mount, Sector

NOTHING, TOO_NEAR, UNKNOWN = "nothing", "too near", "unknown"
Told = float | str
"""Of a beam: how far away its thing is, or a word."""

ROUNDED_RAD = 1e-5
"""Angles come in single precision, and degrees are not radians."""
ROUNDED = Fraction(1, 1000)
"""Of a step of brightness: sines and cosines are rounded."""


@dataclass(frozen=True)
class Beam:
    """One beam from the scanner, in the robot's axes."""

    bearing_rad: float
    told: Told
    ignored: bool = False
    """Whether it sees the robot itself."""


@dataclass(frozen=True)
class Seen:
    """One beam from the robot's centre: where its end is, and what is there."""

    bearing_rad: float
    told: Told
    sweep_rad: float = 0.0
    """Something too near is somewhere between the bearing, and this much further."""


@dataclass(frozen=True)
class Ray:
    """What a ray may show."""

    least: Fraction
    most: Fraction
    surely_unknown: bool
    perhaps_unknown: bool

    def allows(self, value: int) -> bool:
        """Whether a value is one of them."""
        return self.least <= value <= self.most


def beams_in_axes(
    angles_rad: list[float], told: list[Told], mount: Mount, ignored: tuple[Sector, ...]
) -> list[Beam]:
    """The beams of a scanner that is mounted somehow, in the robot's axes."""
    bearings = [mount.yaw_rad + (-angle if mount.upside_down else angle) for angle in angles_rad]
    hidden = [any(_within(bearing, sector) for sector in ignored) for bearing in bearings]
    seen = zip(bearings, told, hidden, strict=True)
    return [Beam(bearing, UNKNOWN if h else t, h) for bearing, t, h in seen]


def _within(bearing_rad: float, sector: Sector) -> bool:
    offset_rad = (bearing_rad - sector.right_rad) % (2 * math.pi)
    return offset_rad <= sector.left_rad - sector.right_rad


def is_at_an_edge(bearing_rad: float, sector: Sector) -> bool:
    """Whether rounding decides if a bearing lies in a sector."""
    edges = (sector.right_rad, sector.left_rad)
    return any(apart_rad(bearing_rad, edge) < ROUNDED_RAD for edge in edges)


def seen_from_centre(beam: Beam, mount: Mount, range_m: float) -> list[Seen]:
    """Where a beam ends, as the robot's centre sees it."""
    if mount.x_m == mount.y_m == 0.0 or beam.told == UNKNOWN:
        return [Seen(beam.bearing_rad, beam.told)]
    place_rad = math.atan2(mount.y_m, mount.x_m)
    if beam.told == TOO_NEAR:
        arc = Seen(place_rad, TOO_NEAR, wrapped(beam.bearing_rad - place_rad))
        return [arc, Seen(beam.bearing_rad, TOO_NEAR)]
    far_m = range_m + math.hypot(mount.x_m, mount.y_m)
    length_m = far_m if isinstance(beam.told, str) else min(beam.told, far_m)
    x = mount.x_m + length_m * math.cos(beam.bearing_rad)
    y = mount.y_m + length_m * math.sin(beam.bearing_rad)
    told = beam.told if isinstance(beam.told, str) else math.hypot(x, y)
    return [Seen(math.atan2(y, x), told)]


def rays_of(seen: list[Seen], step_rad: float, spec: RetinaSpec, *, centred: bool) -> list[Ray]:
    """What each ray may show, by the rule of the eye."""
    by_sector = spec.beams is BeamRule.SECTOR_MINIMUM
    looks = spec.rays if by_sector else spec.rays * spec.samples
    found = [_look(seen, look, looks, step_rad, spec, centred=centred) for look in range(looks)]
    if looks == spec.rays:
        return [_ray(look) for look in found]
    n = spec.samples
    return [_mean(found[first : first + n]) for first in range(0, looks, n)]


def is_hidden(rays: list[Ray], spec: RetinaSpec, *, surely: bool) -> bool:
    """Whether more than a quarter is unknown, of all rays or of those ahead."""
    unknown = [ray.surely_unknown if surely else ray.perhaps_unknown for ray in rays]
    bearings = [spec.fov_rad * (0.5 - (ray + 0.5) / spec.rays) for ray in range(spec.rays)]
    pairs = zip(bearings, unknown, strict=True)
    ahead = [u for b, u in pairs if abs(b) <= 0.25 * spec.fov_rad]
    return any(4 * sum(part) > len(part) for part in (unknown, ahead))


@dataclass(frozen=True)
class _Look:
    least: Fraction
    most: Fraction
    surely_unknown: bool
    perhaps_unknown: bool


def _look(
    seen: list[Seen], look: int, looks: int, step_rad: float, spec: RetinaSpec, *, centred: bool
) -> _Look:
    centre = spec.fov_rad * (0.5 - (look + 0.5) / looks)
    half = 0.5 * spec.fov_rad / looks
    ends = [(s, apart_rad(s.bearing_rad, centre)) for s in seen if s.sweep_rad == 0.0]
    nearest_rad = min(apart for _, apart in ends)
    inside_rad = -1.0 if spec.beams is BeamRule.NEAREST_BEAM else half
    near_rad = max(inside_rad + ROUNDED_RAD, nearest_rad + 2 * ROUNDED_RAD)
    perhaps = [s for s, apart in ends if apart < near_rad]
    surely = [s for s, apart in ends if apart < inside_rad - ROUNDED_RAD]
    if not surely and len(perhaps) == 1:
        surely = perhaps
    blind_rad = max(2.0 * step_rad, half)
    blind_surely = not centred and nearest_rad > blind_rad + ROUNDED_RAD
    blind_perhaps = not centred and nearest_rad > blind_rad - ROUNDED_RAD
    arcs = [s for s in seen if s.sweep_rad != 0.0]
    crossed = [s for s in arcs if _crosses(s, centre, half, -ROUNDED_RAD)]
    touched = [s for s in arcs if _crosses(s, centre, half, ROUNDED_RAD)]
    return _bounds(surely, perhaps, crossed, touched, spec, blind_surely, blind_perhaps)


def _bounds(
    surely: list[Seen],
    perhaps: list[Seen],
    crossed: list[Seen],
    touched: list[Seen],
    spec: RetinaSpec,
    blind_surely: bool,
    blind_perhaps: bool,
) -> _Look:
    lights = [_light(s.told, spec) for s in perhaps if s.told != UNKNOWN]
    known = [_light(s.told, spec) for s in surely if s.told != UNKNOWN]
    unknown_surely = blind_surely or not lights
    unknown_perhaps = blind_perhaps or not known
    if spec.beams is BeamRule.SECTOR_MINIMUM and not (known and max(known) > 0):
        mostly = _mostly_unknown(surely, perhaps)
        unknown_surely = unknown_surely or (mostly[0] and not any(lights))
        unknown_perhaps = unknown_perhaps or mostly[1]
    full = Fraction(255)
    if crossed:
        return _Look(full, full, False, False)
    if unknown_surely:
        return _Look(full, full, not touched, True)
    if known:
        least = max(known)
    else:  # some of those at the border, and it is not known which
        least = min(lights) if surely else min(_light(s.told, spec) for s in perhaps)
    most = full if unknown_perhaps or touched else max(lights)
    return _Look(least, most, False, unknown_perhaps)


def _mostly_unknown(surely: list[Seen], perhaps: list[Seen]) -> tuple[bool, bool]:
    """Whether more than half of a sector's beams are unknown: surely; and perhaps."""
    borders = [s for s in perhaps if s not in surely]
    least = sum(s.told == UNKNOWN for s in surely)
    most = sum(s.told == UNKNOWN for s in perhaps)
    known_most = len(surely) - least + sum(s.told != UNKNOWN for s in borders)
    return least > known_most, most > len(surely) - least


def _light(told: Told, spec: RetinaSpec) -> Fraction:
    """Exact brightness, 0 to 255, before rounding."""
    if told in (TOO_NEAR, UNKNOWN):
        return Fraction(255)
    if isinstance(told, str) or told >= spec.range_m:
        return Fraction(0)
    if spec.shading is Shading.COLOUR:
        return Fraction(255)
    return 255 * (1 - Fraction(told) / Fraction(spec.range_m))


def _ray(look: _Look) -> Ray:
    half = Fraction(1, 2) + ROUNDED
    return Ray(look.least - half, look.most + half, look.surely_unknown, look.perhaps_unknown)


def _mean(looks: list[_Look]) -> Ray:
    """Of several samples: unknown is a ray of which one is."""
    count = len(looks)
    mean = _Look(
        sum((look.least for look in looks), Fraction(0)) / count,
        sum((look.most for look in looks), Fraction(0)) / count,
        any(look.surely_unknown for look in looks),
        any(look.perhaps_unknown for look in looks),
    )
    return _ray(mean)


def _crosses(seen: Seen, centre_rad: float, half_rad: float, slack_rad: float) -> bool:
    """Whether a sector and the arc of something too near have more than a hair in common."""
    sign = math.copysign(1.0, seen.sweep_rad)
    ahead_rad = sign * wrapped(centre_rad - seen.bearing_rad)
    reach_rad = half_rad + slack_rad
    turns = (ahead_rad - 2 * math.pi, ahead_rad, ahead_rad + 2 * math.pi)
    return any(-reach_rad < turn < abs(seen.sweep_rad) + reach_rad for turn in turns)


def wrapped(angle_rad: float) -> float:
    """The same direction, from −π to π."""
    return math.remainder(angle_rad, 2 * math.pi)


def apart_rad(one_rad: float, other_rad: float) -> float:
    """Angle between two directions."""
    return abs((one_rad - other_rad + math.pi) % (2 * math.pi) - math.pi)
