"""Which rate a machine can promise, and why.

A period must hold the lateness of the tick, its work and its record, each at its 99.9th percentile,
what the bus takes, and a quarter more. The pure part: nothing here measures.
"""

from dataclasses import dataclass

from reflexarc.doctoring.check_row import CheckRow, Health, well
from reflexarc.doctoring.lateness_trial import NoPunctuality, Punctuality

MARGIN = 1.25
BUS_NS = 100_000
"""Two messages put and their subscribers' threads waited for, which the trial leaves out."""
MOST_HZ = 1000.0
"""Nothing is promised beyond the rate that loops were measured at, or are here."""


@dataclass(frozen=True)
class Promise:
    """What one scheduling can promise."""

    scheduling: str
    parts_ns: dict[str, int]

    @property
    def rate_hz(self) -> float:
        """The quickest rate whose period holds all parts."""
        return 1e9 / (MARGIN * sum(self.parts_ns.values()))

    @property
    def words(self) -> str:
        """How it comes about."""
        parts = " + ".join(f"{name} {ns / 1e3:.0f}" for name, ns in self.parts_ns.items())
        return f"1 / ({MARGIN:g} × ({parts} µs))"


def promise_of(found: Punctuality) -> Promise:
    """What follows from a measurement."""
    parts = {"lateness": found.lateness.p999_ns}
    if found.tick is not None:
        parts["tick"] = found.tick.p999_ns
    if found.record is not None:
        parts["record"] = found.record.p999_ns
    return Promise(found.scheduling, {**parts, "bus": BUS_NS})


def judge_promise(found: list[Punctuality | NoPunctuality], rate_hz: float, whose: str) -> CheckRow:
    """Whether the rate is kept by any scheduling that can be had here.

    Args:
        found: the trials, ordinary scheduling first.
        rate_hz: what shall be kept.
        whose: rate that is, for the words.
    """
    name = "rate"
    promises = [promise_of(each) for each in found if isinstance(each, Punctuality)]
    if not promises:
        whys = [each.why for each in found if isinstance(each, NoPunctuality)]
        return CheckRow(name, Health.BAD, "could not be measured", "; ".join(whys))
    most_hz = max(MOST_HZ, rate_hz)
    said = ", ".join(f"{p.scheduling} {min(most_hz, p.rate_hz):.0f} Hz" for p in promises)
    best = max(promises, key=lambda each: each.rate_hz)
    if promises[0].scheduling == "ordinary" and promises[0].rate_hz >= rate_hz:
        return well(name, f"{said}; {whose} is {rate_hz:g}")
    found_words = f"{said}; {whose} is {rate_hz:g}"
    if best.rate_hz >= rate_hz:
        why = f"only with a priority: {best.scheduling} {best.words}"
        return CheckRow(name, Health.MIND, found_words, why, "reflexarc run --realtime strict")
    largest = max(best.parts_ns, key=lambda part: best.parts_ns[part])
    why = f"{best.words}; most of it is the {largest}"
    return CheckRow(name, Health.BAD, found_words, why, _REMEDIES[largest])


_REMEDIES = {
    "lateness": "the rows above; another machine, fewer other processes, or a lower rate",
    "tick": "a smaller network, another machine, or a lower rate",
    "record": "a quieter machine, or a lower rate",
    "bus": "a lower rate",
}
