"""What the courses of a log's streams say of its gaps and of its clocks."""

from collections.abc import Collection, Iterator, Sequence

from reflexarc_logs.checking.findings import LogFinding, error, few, time_words, warning
from reflexarc_logs.checking.stream_course import MOST_PERIODS, StreamCourse

MOST_DRIFT = 200e-6
"""A quartz is right to 100 parts in a million; so two of them are within 200 of each other."""
LEAST_DRIFTED_NS = 5_000_000
"""Less is within what the way of a message varies."""
LEAST_SENT_BACK_NS = 20_000_000
"""Several publishers of one topic cross by less."""
_LATEST_END_NS = 1_000_000_000
_STANDSTILL_NS = 1_000_000_000


def gap_findings(courses: Sequence[StreamCourse], whole: StreamCourse) -> Iterator[LogFinding]:
    """Silences of what comes regularly, and messages that are missing by their numbers.

    Args:
        courses: the streams.
        whole: all messages as one.
    """
    standstill = _is_standstill(courses, whole)
    if standstill:
        at = _at(whole.longest_at_ns, whole)
        yield warning(
            "gaps",
            f"nothing at all for {time_words(whole.longest_ns)} {at}: the recorder stood still, "
            "or its clock was set forward",
        )
    for course in courses:
        apart = course.gap_ns - whole.longest_ns if standstill else course.gap_ns
        if course.gap_ns and apart > MOST_PERIODS * (course.period_ns or 0):
            yield warning("gaps", _gap_words(course, whole))
    silent = [c for c in courses if _ends_early(c, whole)]
    if silent:
        said = (f"{c.topic} for {time_words(whole.last_ns - c.last_ns)}" for c in silent)
        yield warning("gaps", f"silent to its end: {few(said)}")
    lost = [f"{c.topic} {c.lost}" for c in courses if c.lost]
    if lost:
        yield warning("gaps", f"messages that never arrived, by their numbers: {few(lost)}")


def clock_findings(courses: Collection[StreamCourse]) -> Iterator[LogFinding]:
    """Clocks that went back, were set, or drift."""
    back = [c for c in courses if c.backs]
    if back:
        most = max(c.most_back_ns for c in back)
        said = few(f"{c.topic} {c.backs}×" for c in back)
        yield error("clocks", f"log time goes back by up to {time_words(most)}: {said}")
    back = [c for c in courses if c.most_sent_back_ns > LEAST_SENT_BACK_NS]
    if back:
        most = max(c.most_sent_back_ns for c in back)
        said = few(c.topic for c in back)
        words = f"senders' times go back by up to {time_words(most)}: {said}"
        yield warning("clocks", f"{words}; out of order, or a clock was set back")
    yield from _step_findings(courses)
    drifting = [c for c in courses if _drifts(c)]
    if drifting:
        said = few(f"{c.topic} {(c.delays.drift() or 0) * 1e6:+.0f} ppm" for c in drifting)
        yield warning("clocks", f"senders' clocks drift against arrival: {said}")


def _step_findings(courses: Collection[StreamCourse]) -> Iterator[LogFinding]:
    stepping = [(c, steps) for c in courses if (steps := c.delays.steps())]
    if stepping:
        said = few(
            f"{c.topic} by {time_words(steps[0].step_ns)} {_at(steps[0].at_ns, c)}"
            for c, steps in stepping
        )
        yield warning("clocks", f"senders' clocks step against arrival: {said}")


def _is_standstill(courses: Sequence[StreamCourse], whole: StreamCourse) -> bool:
    periods = [c.period_ns for c in courses if c.period_ns]
    return bool(periods) and whole.longest_ns > max(_STANDSTILL_NS, MOST_PERIODS * min(periods))


def _gap_words(course: StreamCourse, whole: StreamCourse) -> str:
    period = course.period_ns or 1.0
    return (
        f"{course.topic} silent for {time_words(course.longest_ns)} "
        f"({course.longest_ns / period:.0f} periods of {time_words(period)}) "
        f"{_at(course.longest_at_ns, whole)}"
    )


def _ends_early(course: StreamCourse, whole: StreamCourse) -> bool:
    period = course.period_ns
    return bool(period) and whole.last_ns - course.last_ns > max(
        MOST_PERIODS * (period or 0), _LATEST_END_NS
    )


def _drifts(course: StreamCourse) -> bool:
    drift = course.delays.drift()
    is_much = drift is not None and abs(drift) > MOST_DRIFT
    return is_much and abs(course.delays.drifted_ns()) > LEAST_DRIFTED_NS


def _at(log_ns: int, whole: StreamCourse) -> str:
    return f"at {(log_ns - whole.first_ns) * 1e-9:.2f} s"
