"""Scans become retinas by the sector rule: against a slow picture of all beams."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.sensing.mounting import Mount, mounted
from reflexarc_runtime.sensing.ray_values import shade
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError

EYE = RetinaSpec(rays=16, fov_rad=math.pi, range_m=5.0, beams=BeamRule.SECTOR_MINIMUM)


def slow_values(scan: Scan, mount: Mount, spec: RetinaSpec) -> list[int]:
    """Each return by itself: where it is, which sectors hold that place, how bright it is there."""
    values = [0] * spec.rays
    count = len(scan.ranges_m)
    for beam, range_m in enumerate(scan.ranges_m.tolist()):
        if not 0.0 < range_m < math.inf:
            continue
        angle = scan.start_rad + (scan.end_rad - scan.start_rad) * beam / (count - 1)
        if mount.upside_down:
            angle = -angle
        x = mount.x_m + range_m * math.cos(angle + mount.yaw_rad)
        y = mount.y_m + range_m * math.sin(angle + mount.yaw_rad)
        bearing = math.atan2(y, x)
        ray = math.floor((spec.fov_rad / 2 - bearing) / (spec.fov_rad / spec.rays))
        if 0 <= ray < spec.rays:
            bright = shade(1.0, math.hypot(x, y), spec.range_m, True)
            values[ray] = max(values[ray], bright)
    return values


ranges = st.one_of(st.floats(0.1, 8.0), st.just(math.inf))
mounts = st.builds(
    Mount,
    st.sampled_from([0.0, 0.2, -0.1]),
    st.sampled_from([0.0, 0.1]),
    st.floats(-math.pi, math.pi).map(lambda yaw: round(yaw, 9)),  # else it is lost in a sum
    st.booleans(),
)


@given(st.lists(ranges, min_size=90, max_size=90), mounts)
def test_no_sector_is_darker_than_its_nearest_return_allows(beams: list[float], mount: Mount):
    scan = Scan(-math.pi, math.pi - 2 * math.pi / 90, np.array(beams))
    seen = retina_from_scan(mounted(scan, mount), EYE).ravel().tolist()
    expected = slow_values(scan, mount, EYE)
    assert all(got >= least - 1 for got, least in zip(seen, expected, strict=True))


def test_a_thin_post_between_the_rays_is_seen():
    beams = np.full(181, math.inf)
    beams[94] = 1.0  # at 4°, where the nearest of 16 rays looks along 5.6°
    scan = Scan(-math.pi / 2, math.pi / 2, beams)
    assert retina_from_scan(scan, EYE).max() == 204
    one_beam = dataclasses.replace(EYE, beams=BeamRule.NEAREST_BEAM)
    assert retina_from_scan(scan, one_beam).max() == 0


def test_what_is_too_near_to_be_measured_is_as_bright_as_can_be():
    beams = np.full(181, math.inf)
    beams[90] = -math.inf
    assert retina_from_scan(Scan(-math.pi / 2, math.pi / 2, beams), EYE).max() == 255


def test_a_gap_ahead_is_refused_and_the_reason_names_the_flag():
    beams = np.full(181, math.inf)
    beams[72:110] = 0.0
    with pytest.raises(UnusableScanError, match=r"rays ahead unknown.*--no-return zero"):
        retina_from_scan(Scan(-math.pi / 2, math.pi / 2, beams), EYE)


def test_a_sweep_of_57_turns_is_refused():
    with pytest.raises(UnusableScanError, match=r"turns.*--angles degrees"):
        retina_from_scan(Scan(-180.0, 179.0, np.ones(360)), EYE)
