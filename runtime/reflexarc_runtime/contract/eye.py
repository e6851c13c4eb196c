"""The eye of a policy: how many rays, over which field, and what a ray's value means."""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError

_MAX_RETINA_VALUES = 1 << 16

_require = partial(require, error=ContractError)


class Shading(StrEnum):
    """What a ray's value says about the first thing that it meets."""

    COLOUR = "colour"
    """Its colour; background is 0 (the paper, section 4.2)."""
    NEARNESS = "nearness"
    """Its colour × (1 − distance / range): brighter is nearer."""


class BeamRule(StrEnum):
    """What a ray shows of the directions within its sector: beams of a scan, or its own samples."""

    NEAREST_BEAM = "nearest_beam"
    """The beam whose bearing is nearest to the ray's; of several samples the mean."""
    SECTOR_MINIMUM = "sector_minimum"
    """The nearest return of all beams in the ray's sector; of several samples the nearest."""


@dataclass(frozen=True)
class RetinaSpec:
    """The eye: how many rays, over which field, and what a value means."""

    rays: int = 16
    """Rays of one eye, at the centres of equal sectors of the field of view."""
    fov_rad: float = math.pi
    """Field of view of one eye, in (0, 2π]."""
    range_m: float = 5.0
    """Distance at and beyond which nothing is seen."""
    shading: Shading = Shading.NEARNESS
    """What a ray's value means."""
    frames: int = 1
    """How many of the last accepted retinas the policy sees, oldest first."""
    eyes: int = 1
    """1 or 2."""
    baseline_m: float = 0.0
    """Distance between two eyes; 0 with one."""
    channels: int = 1
    """1 (grey) or 3 (RGB)."""
    samples: int = 1
    """Directions, evenly within a ray's sector, in which an eye without a scanner looks. More than
    1: by `sector_minimum` nothing slips between two rays that is wider than the gap between two
    samples; by `nearest_beam` edges move smoothly from ray to ray (anti-aliasing)."""
    beams: BeamRule = BeamRule.NEAREST_BEAM
    """What a ray shows of its sector. What is trained anew asks for `sector_minimum`; a contract
    that names no rule is one of before, and means this one."""

    def __post_init__(self) -> None:
        _require(1 <= self.rays <= 4096, "retina.rays", "1 to 4096", self.rays)
        _require(0.0 < self.fov_rad <= 2 * math.pi, "retina.fov_rad", "in (0, 2π]", self.fov_rad)
        _require(0.0 < self.range_m < math.inf, "retina.range_m", "positive", self.range_m)
        _require(1 <= self.frames <= 16, "retina.frames", "1 to 16", self.frames)
        _require(self.eyes in (1, 2), "retina.eyes", "1 or 2", self.eyes)
        _require(self.channels in (1, 3), "retina.channels", "1 or 3", self.channels)
        _require(0.0 <= self.baseline_m < math.inf, "retina.baseline_m", "≥ 0", self.baseline_m)
        _require(1 <= self.samples <= 16, "retina.samples", "1 to 16", self.samples)
        _require(self.size <= _MAX_RETINA_VALUES, "retina", "at most 65536 values", self.size)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of one retina: (eyes, rays, channels)."""
        return (self.eyes, self.rays, self.channels)

    @property
    def stack_shape(self) -> tuple[int, int, int, int]:
        """Shape of what the policy sees at one tick: (frames, eyes, rays, channels)."""
        return (self.frames, *self.shape)

    @property
    def size(self) -> int:
        """Values, and bytes, of one retina."""
        return self.eyes * self.rays * self.channels

    @property
    def encoding(self) -> str:
        """Pixel encoding of a retina on the bus (`foxglove.RawImage`)."""
        return "mono8" if self.channels == 1 else "rgb8"
