"""Whether a scan's retina and a guard's beams tell no lie, by the slow picture of all beams."""

import math

import numpy as np

from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.sensing.distances import beams_of_scan
from reflexarc_runtime.sensing.mounting import Mount
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError
from support.drawn_scans import Drawn
from support.slow_scans import (
    ROUNDED_RAD,
    TOO_NEAR,
    UNKNOWN,
    Beam,
    Ray,
    apart_rad,
    beams_in_axes,
    is_at_an_edge,
    is_hidden,
    rays_of,
    seen_from_centre,
)

SEEN, REFUSED = "seen", "refused"
RADIUS_M = 0.2
GUARD = Guard.for_contract(
    GuardSettings(footprint=Footprint(radius_m=RADIUS_M), margin_m=0.001), PolicyContract()
)
AGE_S = 0.1
AHEAD = [(math.cos(turn), math.sin(turn), 0.0) for turn in np.linspace(-math.pi, math.pi, 9)]


def judge(drawn: Drawn) -> str:
    """Whether the scan was seen or refused.

    Raises:
        AssertionError: it was seen wrongly, or should not have been refused.
    """
    beams = beams_in_axes(drawn.angles_rad, list(drawn.told), drawn.mount, drawn.ignored)
    if any(is_at_an_edge(beam.bearing_rad, s) for beam in beams for s in drawn.ignored):
        return "left out"  # rounding decides what is ignored
    step_rad = abs(drawn.step_rad)
    centred = drawn.mount.x_m == drawn.mount.y_m == 0.0
    seen = [s for beam in beams for s in seen_from_centre(beam, drawn.mount, drawn.spec.range_m)]
    rays = rays_of(seen, step_rad, drawn.spec, centred=centred)
    try:
        scan = drawn.sent()
        values = retina_from_scan(scan, drawn.spec).ravel().tolist()
    except (UnusableScanError, UnusableMessageError) as refusal:
        if may_be_refused(drawn, beams, rays, centred):
            return REFUSED
        raise AssertionError(f"refused: {refusal}") from refusal
    assert not is_hidden(rays, drawn.spec, surely=True), "too much is unknown"
    check_covered(drawn, beams, centred)
    for number, (value, ray) in enumerate(zip(values, rays, strict=True)):
        least, most = float(ray.least), float(ray.most)
        assert ray.allows(value), f"ray {number} shows {value}, not {least:.2f} to {most:.2f}"
    check_guard(scan, beams, drawn.mount)
    return SEEN


def may_be_refused(drawn: Drawn, beams: list[Beam], rays: list[Ray], centred: bool) -> bool:
    """Whether the documentation gives a reason."""
    if is_hidden(rays, drawn.spec, surely=False):
        return True
    step_rad = abs(drawn.step_rad)
    if step_rad > math.pi - ROUNDED_RAD:  # half a turn in degrees may be more, once it is sent
        return True
    return centred and farthest_rad(drawn, beams) > 0.5 * step_rad - ROUNDED_RAD


def check_covered(drawn: Drawn, beams: list[Beam], centred: bool) -> None:
    """No ray looks where no beam goes."""
    if centred:
        assert farthest_rad(drawn, beams) < abs(drawn.step_rad) + ROUNDED_RAD, "not covered"


def farthest_rad(drawn: Drawn, beams: list[Beam]) -> float:
    """How far the nearest beam is from where a ray or one of its samples looks, at most."""
    spec = drawn.spec
    looks = spec.rays * (spec.samples if spec.beams is BeamRule.NEAREST_BEAM else 1)
    centres = [spec.fov_rad * (0.5 - (look + 0.5) / looks) for look in range(looks)]
    bearings = [beam.bearing_rad for beam in beams]
    return max(min(apart_rad(bearing, centre) for bearing in bearings) for centre in centres)


def check_guard(scan: Scan, beams: list[Beam], mount: Mount) -> None:
    """No motion goes where something is, or where nothing is known."""
    ranges, places = beams_of_scan(scan), [place for b in beams if (place := _place(b, mount))]
    for twist in AHEAD:
        share = GUARD.share(twist, ranges, AGE_S)
        if share > 0.0:
            heading_rad = math.atan2(twist[1], twist[0])
            nearest = min(beams, key=lambda beam: apart_rad(beam.bearing_rad, heading_rad))
            assert not nearest.ignored, f"a motion into what is ignored: {twist}"
            way_m = share * (AGE_S + GUARD.valid_for_s + GUARD.settings.delay_s)
            met = [place for place in places if _lies_on_the_way(*place, twist, way_m)]
            assert not met, f"{met[0]} on the way of {twist}"


def _place(beam: Beam, mount: Mount) -> tuple[float, float] | None:
    """Where the thing of a beam is, or may be."""
    if beam.ignored:
        return None  # it is the robot itself
    if beam.told == UNKNOWN:
        if mount.x_m or mount.y_m:
            return None  # it may be anywhere on the beam; the centre's own bearing counts
        length_m = RADIUS_M + 0.01
    elif beam.told == TOO_NEAR:
        length_m = 0.04
    elif isinstance(beam.told, str) or beam.told > 1.0:
        return None
    else:
        length_m = beam.told
    x_m = mount.x_m + length_m * math.cos(beam.bearing_rad)
    return x_m, mount.y_m + length_m * math.sin(beam.bearing_rad)


def _lies_on_the_way(
    x_m: float, y_m: float, twist: tuple[float, float, float], way_m: float
) -> bool:
    """Whether a disc that goes straight meets a point that is not behind it."""
    along_m, beside_m = x_m * twist[0] + y_m * twist[1], abs(y_m * twist[0] - x_m * twist[1])
    if along_m <= 0.01 or beside_m >= RADIUS_M - 1e-6:
        return False
    return along_m - math.sqrt(RADIUS_M**2 - beside_m**2) < way_m - 1e-6
