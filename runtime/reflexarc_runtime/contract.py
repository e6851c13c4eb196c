"""The policy contract: the only definition of what a policy sees and does.

The trainer builds its world's eye from it, the exporter writes it into the ONNX file, the body
builds its senses from it, the runtime checks every message against it, the log carries it.

Frames and signs: x ahead, y to the left, bearings counter-clockwise with 0 ahead. Index 0 of a
retina is the leftmost ray. SI units; times on the bus are integer nanoseconds.
"""

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from typing import Any, Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import ContractError

SCHEMA_VERSION = 2
"""1: first. 2: `retina.samples`."""
METADATA_KEY = "reflexarc.contract"

_MAX_RETINA_VALUES = 1 << 16

_require = partial(require, error=ContractError)


class Shading(StrEnum):
    """What a ray's value says about the first thing that it meets."""

    COLOUR = "colour"
    """Its colour; background is 0 (the paper, section 4.2)."""
    NEARNESS = "nearness"
    """Its colour × (1 − distance / range): brighter is nearer."""


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
    """Directions, evenly within a ray's sector, of whose brightness a ray shows the mean. With more
    than 1, edges move smoothly from ray to ray (anti-aliasing)."""

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


@dataclass(frozen=True)
class Action:
    """One motion that the policy can choose, in the agent's frame."""

    name: str
    linear_mps: float
    lateral_mps: float
    angular_radps: float = 0.0

    def __post_init__(self) -> None:
        speeds = (self.linear_mps, self.lateral_mps, self.angular_radps)
        _require(all(map(math.isfinite, speeds)), f"action {self.name!r}", "finite", speeds)


def sideways_actions(forward_mps: float = 1.0, lateral_mps: float = 1.0) -> tuple[Action, ...]:
    """The paper's actions: stay, left, right at uniform forward speed.

    In this order a tie of all values stays on course (winner takes all, the first one wins).
    """
    return (
        Action("stay", forward_mps, 0.0),
        Action("left", forward_mps, lateral_mps),
        Action("right", forward_mps, -lateral_mps),
    )


@dataclass(frozen=True)
class Provenance:
    """Where a policy comes from."""

    preset: str = ""
    seed: int = 0
    config: Mapping[str, Any] = field(default_factory=dict)
    """The resolved training configuration."""
    config_hash: str = ""
    """SHA-256 of the configuration's canonical JSON."""
    versions: Mapping[str, str] = field(default_factory=dict)
    commit: str = ""
    scores: Mapping[str, float] = field(default_factory=dict)
    """What evaluation measured, by name with unit."""


@dataclass(frozen=True)
class GoldenVectors:
    """Retina stacks with the Q-values and actions that the trainer computed for them.

    The runtime reproduces them at load on the backend that it will use, or refuses to start.
    """

    retinas: tuple[tuple[int, ...], ...] = ()
    """Each one a flattened stack (frames, eyes, rays, channels), values 0 to 255."""
    q_values: tuple[tuple[float, ...], ...] = ()
    """Float32 values; their decimal form restores the same bits."""
    actions: tuple[int, ...] = ()


@dataclass(frozen=True)
class PolicyContract:
    """What a policy sees, what it does, how fast, and how to know that it is intact."""

    retina: RetinaSpec = field(default_factory=RetinaSpec)
    actions: tuple[Action, ...] = field(default_factory=sideways_actions)
    safe_command: Action = field(default_factory=lambda: Action("stop", 0.0, 0.0))
    """Sent whenever the verdict is not OK."""
    rate_hz: float = 50.0
    """Rate of the sense–act loop."""
    max_input_age_s: float = 0.1
    """An input older than this is stale."""
    provenance: Provenance = field(default_factory=Provenance)
    golden: GoldenVectors = field(default_factory=GoldenVectors)

    def __post_init__(self) -> None:
        _require(2 <= len(self.actions) <= 64, "actions", "2 to 64", len(self.actions))
        names = [action.name for action in self.actions]
        _require(len(set(names)) == len(names), "actions", "distinct names", names)
        _require(0.1 <= self.rate_hz <= 10_000.0, "rate_hz", "0.1 to 10000", self.rate_hz)
        age_s = self.max_input_age_s
        _require(0.0 < age_s <= 3600.0, "max_input_age_s", "in (0, 3600]", age_s)
        _check_golden(self)

    @property
    def max_input_age_ns(self) -> int:
        """`max_input_age_s` in nanoseconds."""
        return round(self.max_input_age_s * 1e9)

    def to_json(self) -> str:
        """The contract as canonical JSON, with its schema version."""
        document = {"schema": SCHEMA_VERSION, **dataclasses.asdict(self)}
        return json.dumps(document, sort_keys=True, separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read a contract back.

        Raises:
            ContractError: not JSON, a schema newer than this package, or a field that is missing,
                unknown, of the wrong type or out of range.
        """
        source = MappingSource(_parse(text), "contract", ContractError)
        return fill(cls, source, require_all=True)


def _parse(text: str) -> dict[str, Any]:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ContractError(f"contract: expected JSON, got {text[:40]!r}… ({error})") from None
    if not isinstance(document, dict):
        raise ContractError(f"contract: expected a JSON object, got {type(document).__name__}")
    version = _schema(document.pop("schema", None))
    return _migrated(document, version)


def _migrated(document: dict[str, Any], version: int) -> dict[str, Any]:
    """A document of an older schema as one of today's."""
    if version < 2 and isinstance(document.get("retina"), dict):
        return {**document, "retina": {**document["retina"], "samples": 1}}
    return document


def _schema(version: object) -> int:
    if not isinstance(version, int) or isinstance(version, bool) or version < 1:
        raise ContractError(f"contract: expected a schema version from 1 on, got {version!r}")
    if version > SCHEMA_VERSION:
        raise ContractError(
            f"contract: schema {version} is newer than this reflexarc reads ({SCHEMA_VERSION}); "
            "upgrade reflexarc on this machine"
        )
    return version


def _check_golden(contract: PolicyContract) -> None:
    golden, count = contract.golden, len(contract.golden.retinas)
    lengths = (len(golden.q_values), len(golden.actions))
    _require(lengths == (count, count), "golden", f"{count} of each", lengths)
    known = len(contract.actions)
    fits = all(0 <= action < known for action in golden.actions)
    _require(fits, "golden.actions", f"0 to {known - 1}", "others")
    size = contract.retina.frames * contract.retina.size
    for retina, q_values in zip(golden.retinas, golden.q_values, strict=True):
        _require(len(retina) == size, "golden.retinas", f"{size} values each", len(retina))
        _require(all(0 <= v <= 255 for v in retina), "golden.retinas", "values 0 to 255", "others")
        wanted = len(contract.actions)
        _require(len(q_values) == wanted, "golden.q_values", f"{wanted} each", len(q_values))
