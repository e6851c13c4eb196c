"""The results of the demo, section by section; `--json` prints exactly this."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LearningResult:
    """What was learned, on the reference field's test worlds."""

    preset: str
    steps: int
    seconds: float
    agents: int
    """How many agents measured each figure."""
    blind_contacts_per_100m: float
    random_contacts_per_100m: float
    learned_contacts_per_100m: float
    learned_low: float
    learned_high: float
    share_of_blind: float


@dataclass(frozen=True)
class DriveResult:
    """How punctual the loop was, and where the body went."""

    ticks: int
    rate_hz: float
    lateness_p50_ns: int
    lateness_p99_ns: int
    lateness_max_ns: int
    skipped_slots: int
    verdicts: dict[str, int]
    distance_m: float
    contacts: int


OF_THE_RUN = (
    "ticks",
    "rate_hz",
    "lateness_p50_ns",
    "lateness_p99_ns",
    "lateness_max_ns",
    "skipped_slots",
    "verdicts",
)
"""What the runtime itself says, by the names of `run --json`."""


@dataclass(frozen=True)
class LogResult:
    """What was recorded."""

    path: str
    messages: int
    bytes: int
    seconds: float


@dataclass(frozen=True)
class ReplayResult:
    """What the replay of the drive found."""

    verdict: str
    levels: dict[str, dict[str, int]]
    """Level → compared and identical ticks."""


@dataclass(frozen=True)
class LidarResult:
    """How the policy did on lidar scans."""

    source: str
    """The file, or that it was simulated."""
    scans: int
    ticks: int
    ok_share: float
    """Share of the ticks with verdict OK."""
    verdict: str
    """Of the replay."""
    levels: dict[str, int]
    """Level → identical ticks."""
    log: str


@dataclass(frozen=True)
class DemoResult:
    """All results of the demo."""

    learning: LearningResult
    drive: DriveResult
    log: LogResult
    replay: ReplayResult
    lidar: LidarResult
    files: dict[str, str]
