"""What was found about a candidate policy, as data: log by log, the worst first.

Replay is open loop: a candidate is asked about what another policy saw, and what it answers moves
nothing. A flip is a tick at which it prefers another action than was preferred then. A reversal is
a flip to the opposite one. The margin of a flip is how sure the record was: the Q-value of what was
preferred minus that of what the candidate prefers, both as recorded.
"""

import dataclasses
from dataclasses import dataclass
from typing import Any

from reflexarc_logs.reading.incidents import IncidentKind

NO_ACTION = -1
"""Index of an action, where there is none."""
VERDICTS = ("within the limits", "beyond the limits", "not judged")


@dataclass(frozen=True, slots=True)
class JudgedFlip:
    """A tick at which the candidate prefers another action."""

    tick: int
    time_s: float
    """Since the log's first tick."""
    recorded: int
    """Index of the action that was preferred when it was recorded."""
    candidate: int
    margin: float
    """Between these two, by the recorded Q-values."""
    candidate_margin: float
    """The same by the candidate's Q-values, the other way round: how sure it is."""
    is_reversal: bool
    recorded_q_values: tuple[float, ...]
    candidate_q_values: tuple[float, ...]
    retina: bytes
    """What both were given, in the shape of `LogJudgement.retina_shape`."""


@dataclass(frozen=True, slots=True)
class IncidentAnswer:
    """Something that happened, and what the candidate prefers there."""

    kind: IncidentKind
    tick: int
    time_s: float
    words: str
    """What the log says of it."""
    asked_tick: int
    """The last tick up to then at which the policy was asked; -1: none."""
    recorded: int
    """What was preferred at that tick; `NO_ACTION`: nothing."""
    candidate: int


@dataclass(frozen=True)
class LogJudgement:
    """A candidate on one log."""

    log: str
    """Its name: the path below the folder that all judged logs have in common."""
    problem: str = ""
    """Why it could not be judged; empty: it was."""
    broken: tuple[str, ...] = ()
    """Which limits are exceeded, each in words."""
    run_id: str = ""
    recorded_policy: str = ""
    """Hash of the policy that drove."""
    actions: tuple[str, ...] = ()
    retina_shape: tuple[int, ...] = ()
    """(frames, eyes, rays, channels), uint8, the oldest frame first."""
    ticks: int = 0
    """Ticks that count: the policy was asked at them, and they lie in the window."""
    flips: int = 0
    """Flips that count."""
    reversals: int = 0
    """Those among them to the opposite action."""
    below_margin: int = 0
    """Flips that do not count because their margin is below the least one."""
    rounding: int = 0
    """Flips that do not count because two backends may differ by as much."""
    faults: int = 0
    """Ticks at which a Q-value of the candidate is no finite number: a loop would stop."""
    warming_up: int = 0
    """Ticks that do not count because the candidate's memory has only begun."""
    largest_margin: float = 0.0
    first_tick: int = -1
    """Of the flips that count; -1: none."""
    first_s: float = 0.0
    shown_flips: tuple[JudgedFlip, ...] = ()
    """The flips that count, by tick; if there are too many to keep, those of the largest
    margins."""
    more_flips: int = 0
    """Those that count and are not in `shown_flips`."""
    incidents: tuple[IncidentAnswer, ...] = ()
    more_incidents: int = 0
    notes: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Flips by ticks that count, in [0, 1]."""
        return self.flips / self.ticks if self.ticks else 0.0

    @property
    def exit_status(self) -> int:
        """0: within the limits. 1: beyond. 2: it could not be judged."""
        return 2 if self.problem else int(bool(self.broken))

    @property
    def verdict(self) -> str:
        """The exit status in words."""
        return VERDICTS[self.exit_status]

    def action(self, index: int) -> str:
        """The name of an action."""
        return self.actions[index] if 0 <= index < len(self.actions) else "none"

    def to_plain(self) -> dict[str, Any]:
        """Values that can be written as JSON."""
        document = dataclasses.asdict(self)
        for flip in document["shown_flips"]:
            flip["retina"] = flip["retina"].hex()
        return document

    @classmethod
    def from_plain(cls, document: dict[str, Any]) -> "LogJudgement":
        """Read it back."""
        listed = {key for key, value in document.items() if isinstance(value, list)}
        values = {**document, **{key: tuple(document[key]) for key in listed}}
        values["shown_flips"] = tuple(_flip(one) for one in document["shown_flips"])
        values["incidents"] = tuple(IncidentAnswer(**one) for one in document["incidents"])
        return cls(**values)


def _flip(document: dict[str, Any]) -> JudgedFlip:
    return JudgedFlip(
        **{
            **document,
            "retina": bytes.fromhex(document["retina"]),
            "recorded_q_values": tuple(document["recorded_q_values"]),
            "candidate_q_values": tuple(document["candidate_q_values"]),
        }
    )
