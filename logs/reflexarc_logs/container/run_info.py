"""What a log says about the run that it holds: the metadata record `reflexarc.run`.

One string for each field, so that any MCAP tool can show it.
"""

import dataclasses
import json
import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import metadata
from typing import Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, SENSORS
from reflexarc_runtime.policy.policy import Backend

RUN = "reflexarc.run"
"""Name of the metadata record."""

CLOCKS = ("monotonic", "lockstep")
SENDERS_CLOCK, WALL_CLOCK = "sender", "wall"
PACES = ("", "rate", "input", "lockstep")
PUBLISH_CLOCKS = (SENDERS_CLOCK, WALL_CLOCK)
UNKNOWN_BACKEND = "unknown"
"""A listener on the bus cannot tell what computed a tick; its log is compared to the contract's
`q_tolerance`."""

RECORDERS = ("run", "record", "import", "decide")
LOOPS = ("run", "decide")
"""Those whose log holds the loop's own inputs, in its own order."""

FIRST_RULES = 1
_RENAMED = {"seed": "policy_seed"}

_PACKAGES = ("reflexarc", "numpy", "onnx", "onnxruntime", "protobuf", "mcap", "eclipse-zenoh")


@dataclass(frozen=True)
class RunInfo:
    """One run: which robot, which policy, which host, and by which clock."""

    run_id: str
    """A uuid4 in hexadecimal, new for each run, so that a restart never merges two."""
    robot: str = DEFAULT_ROBOT
    """First part of every key."""
    input: str = "retina"
    """Which sensor the runtime decided on: retina or scan."""
    backend: str = Backend.NUMPY.value
    """What computed the policy, as far as the recorder knows."""
    rate_hz: float = 0.0
    clock: str = "monotonic"
    """monotonic or lockstep."""
    pace: str = ""
    """When a tick began: `rate`, `input` or `lockstep`; empty in logs of before, and where no loop
    recorded."""
    recorded_by: str = "run"
    """`run`: the loop handed over its own inputs, in the order in which it used them. `record`:
    a listener on the bus wrote what it heard, in its own order; ticks and inputs do not pair.
    `import`: made of a file of another system; it has no ticks. `decide`: the loop ran on another
    log's sensors."""
    rules: int = FIRST_RULES
    """Version of the controller's rules; a log that names none is of the first. The recorder fills
    it in."""
    guard: str = ""
    """Settings of the guard, JSON; empty: there was none, as in every log of before."""
    senses: str = ""
    """How the sense was told to read what came, JSON; empty before version 4 of the rules."""
    policy_seed: int = 0
    """Seed with which the policy was trained; where a body drove, its `body` messages say."""
    commit: str = ""
    host: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    policy_hash: str = ""
    """SHA-256 of the attached policy; empty without one. The recorder fills it in."""
    publish_clock: str = SENDERS_CLOCK
    """By which clock `publish_time` is. `sender`: as the sender stamped it, in every log of before.
    `wall`: that and `wall_offset_ns`, so that viewers show it together with `log_time`. The
    recorder fills it in."""
    wall_offset_ns: int = 0
    """Wall clock minus monotonic clock at the start; 0 in lockstep. The recorder fills it in."""

    def to_metadata(self) -> dict[str, str]:
        """One string for each field."""
        document = {f.name: str(getattr(self, f.name)) for f in dataclasses.fields(self)}
        versions = json.dumps(dict(self.versions), sort_keys=True)
        return {**document, "rate_hz": repr(float(self.rate_hz)), "versions": versions}

    @property
    def publish_shift_ns(self) -> int:
        """What `publish_time` is ahead of the sender's own stamp."""
        return self.wall_offset_ns if self.publish_clock == WALL_CLOCK else 0

    @property
    def replay_backend(self) -> Backend:
        """What replay computes with, unless told otherwise: the same; NumPy where unknown."""
        return Backend.NUMPY if self.backend == UNKNOWN_BACKEND else Backend(self.backend)

    @classmethod
    def from_metadata(cls, document: Mapping[str, str]) -> Self:
        """Read it back; fields of a newer version are left alone, missing ones have defaults.

        Raises:
            LogError: a field that cannot be what it should be.
        """
        if "run_id" not in document:
            raise LogError(f"{RUN}: expected a run_id, got none; the log is damaged")
        source = MappingSource(_with_versions(_renamed(document)), RUN, LogError)
        info = fill(cls, source, _number, ignore_unknown=True)
        _check(info)
        return info


def installed_versions() -> dict[str, str]:
    """Versions of Python and of the packages that a run rests on."""
    versions = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue  # run from a checkout, or without an optional part
    return versions


def _renamed(document: Mapping[str, str]) -> Mapping[str, str]:
    """The metadata of an older log under the names of today."""
    return {_RENAMED.get(name, name): text for name, text in document.items()}


def _with_versions(document: Mapping[str, str]) -> dict[str, object]:
    """The metadata with the one field whose text is JSON as what it stands for."""
    text = document.get("versions", "{}")
    try:
        return {**document, "versions": json.loads(text)}
    except (ValueError, RecursionError):
        raise LogError(f"{RUN}.versions: got {text[:40]!r}; the log is damaged") from None


def _number(text: object, kind: type, path: KeyPath) -> object:
    """What the text of a number stands for."""
    try:
        return kind(text)
    except ValueError:
        raise ValueError(f"got {str(text)[:40]!r}; the log is damaged") from None


def _check(info: RunInfo) -> None:
    choices = {
        "input": (info.input, tuple(SENSORS)),
        "backend": (info.backend, (*(b.value for b in Backend), UNKNOWN_BACKEND)),
        "clock": (info.clock, CLOCKS),
        "pace": (info.pace, PACES),
        "recorded_by": (info.recorded_by, RECORDERS),
        "publish_clock": (info.publish_clock, PUBLISH_CLOCKS),
    }
    fits = 0 <= info.wall_offset_ns < 1 << 64
    require(fits, f"{RUN}.wall_offset_ns", "0 to 2^64 − 1", info.wall_offset_ns, LogError)
    for name, (value, allowed) in choices.items():
        known = " or ".join(allowed)
        require(value in allowed, f"{RUN}.{name}", known, repr(value[:40]), LogError)
