"""Did ever two runtimes move one body, and did ever a lonely pair stand? Judged by a witness.

The witness hears poses, leases and commands on the bus, by sender. Each runtime
has a policy with an ahead speed of its own, so that a step of a body tells by itself who moved it:
speed = way / period. What the body says about its lease is compared with that, never believed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

MS = 1_000_000
SLACK_NS = 150 * MS
"""A lease may be lost on the way, and is said again within a second only if nothing changed."""
SETTLED_NS = 500 * MS
IDLE_NS = 250 * MS
_SAME_MPS = 0.02


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a body: when it was heard, and how fast it went ahead."""

    time_ns: int
    ahead_mps: float


@dataclass
class Evidence:
    """What the witness heard. Senders are bytes."""

    steps: dict[bytes, list[Step]] = field(default_factory=dict)
    leases: dict[bytes, list[tuple[int, bytes]]] = field(default_factory=dict)
    """Of each body: when it was said, and who holds it."""
    speeds: dict[bytes, float] = field(default_factory=dict)
    """Of each runtime: the ahead speed of its driving commands."""
    commands: dict[bytes, list[tuple[int, bytes]]] = field(default_factory=dict)
    """Of each runtime: when it sent a driving command, and to which body."""
    contacts: set[tuple[bytes, int]] = field(default_factory=set)
    """(body, when): at a contact it stands elsewhere, so that step tells nothing."""


def moved_by_others(evidence: Evidence) -> list[str]:
    """Each step of a body that its holder did not order: nobody holds it, or another speed."""
    found = []
    for body, steps in evidence.steps.items():
        for step in steps:
            if step.ahead_mps <= _SAME_MPS or (body, step.time_ns) in evidence.contacts:
                continue
            holders = _holders(evidence.leases.get(body, []), step.time_ns)
            if not any(_ordered(evidence, holder, body, step) for holder in holders):
                found.append(
                    f"{body.hex()[:8]} went {step.ahead_mps:.2f} m/s at {step.time_ns}: "
                    f"held by {[holder.hex()[:8] for holder in holders]}"
                )
    return found


def alternations(evidence: Evidence) -> list[str]:
    """Each change of who moves a body, by its speed alone, without a new holder beside it."""
    found = []
    for body, steps in evidence.steps.items():
        moving = [
            step
            for step in steps
            if step.ahead_mps > _SAME_MPS and (body, step.time_ns) not in evidence.contacts
        ]
        leases = evidence.leases.get(body, [])
        for before, after in pairwise(moving):
            same = abs(before.ahead_mps - after.ahead_mps) <= _SAME_MPS
            handed_over = any(
                before.time_ns - SLACK_NS <= time_ns <= after.time_ns + SLACK_NS
                for (time_ns, holder), (_, former) in zip(leases[1:], leases, strict=False)
                if holder != former
            )
            if not same and not handed_over:
                found.append(f"{body.hex()[:8]}: another speed at {after.time_ns}")
    return found


def idle(
    evidence: Evidence,
    lives: Mapping[bytes, Sequence[tuple[int, int]]],
    oversleeps: Sequence[tuple[int, int]] = (),
) -> tuple[list[str], int, int]:
    """Where exactly one body and one runtime lived for 0.5 s, and the body stood.

    Args:
        evidence: of the witness.
        lives: of each body and runtime: from when to when it was heard and ran.
        oversleeps: when the machine did not run the witness or a loop, from and to.

    Returns:
        The idle stretches that nothing excuses, how many were excused, and the time judged, ns.
    """
    found, excused, judged_ns = [], 0, 0
    for body, begin_ns, end_ns in _pairs(evidence, lives):
        moving = [s.time_ns for s in evidence.steps[body] if s.ahead_mps > _SAME_MPS]
        inside = [time_ns for time_ns in moving if begin_ns <= time_ns < end_ns]
        judged_ns += end_ns - begin_ns
        for before_ns, after_ns in pairwise([begin_ns, *inside, end_ns]):
            slept_ns = _shared_ns(oversleeps, before_ns, after_ns)
            if after_ns - before_ns - slept_ns > IDLE_NS:
                said = f"stood {(after_ns - before_ns) / MS:.0f} ms from {before_ns}"
                found.append(f"{body.hex()[:8]} {said}")
            elif after_ns - before_ns > IDLE_NS:
                excused += 1
    return found, excused, judged_ns


def _shared_ns(stretches: Sequence[tuple[int, int]], begin_ns: int, end_ns: int) -> int:
    """How much of a time lies in stretches, which may overlap."""
    shared_ns, covered_ns = 0, begin_ns
    for from_ns, to_ns in sorted(stretches):
        from_ns, to_ns = max(from_ns, covered_ns), min(to_ns, end_ns)
        if to_ns > from_ns:
            shared_ns += to_ns - from_ns
            covered_ns = to_ns
    return shared_ns


def _holders(leases: Sequence[tuple[int, bytes]], time_ns: int) -> set[bytes]:
    """Who may have held a body at a time, as far as two channels can tell; nobody is left out."""
    near = {h for at_ns, h in leases if abs(at_ns - time_ns) <= SLACK_NS}
    before = [h for at_ns, h in leases if at_ns < time_ns - SLACK_NS]
    return {holder for holder in (*near, *before[-1:]) if holder}


def _ordered(evidence: Evidence, holder: bytes, body: bytes, step: Step) -> bool:
    speed = evidence.speeds.get(holder)
    same = speed is not None and abs(speed - step.ahead_mps) <= _SAME_MPS
    window = (step.time_ns - 2 * SLACK_NS, step.time_ns + SLACK_NS)
    sent = (n for n, to in evidence.commands.get(holder, []) if to == body)
    return same and any(window[0] <= time_ns <= window[1] for time_ns in sent)


def _pairs(
    evidence: Evidence, lives: Mapping[bytes, Sequence[tuple[int, int]]]
) -> list[tuple[bytes, int, int]]:
    """(body, from, to): exactly one of each lived, and had for 0.5 s."""
    edges = sorted({edge for spans in lives.values() for span in spans for edge in span})
    found: list[tuple[bytes, int, int]] = []
    for begin_ns, end_ns in pairwise(edges):
        here = [w for w, spans in lives.items() if any(a <= begin_ns < b for a, b in spans)]
        bodies = [who for who in here if who in evidence.steps]
        if len(bodies) == 1 and len(here) == 2 and end_ns - begin_ns > SETTLED_NS:
            found.append((bodies[0], begin_ns + SETTLED_NS, end_ns))
    return found
