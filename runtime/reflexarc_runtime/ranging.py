"""What a guard knows of ranges that come on a topic of their own: from whom, and how old.

Pure, as the controller is. The topic is bound to one sender, as the loop is to one body: whoever
else speaks is not believed, and shows. A scan that is broken is no range until a good one comes.
"""

from dataclasses import replace

from reflexarc_runtime.backlog import NO_LAG, Lag, backlog_in_words
from reflexarc_runtime.beams import Beams
from reflexarc_runtime.controller_state import RangeState, bound_after
from reflexarc_runtime.messages.wire import Message, UndecodableError, UnfitError
from reflexarc_runtime.sensing.distances import beams_of_scan
from reflexarc_runtime.sensing.ranges import Ranged, decode_ranges
from reflexarc_runtime.sensing.sense_settings import SenseSettings


def heard(
    known: RangeState,
    message: Message,
    oldest_ns: int,
    settings: SenseSettings,
    ages_backlogs: bool,
) -> RangeState:
    """What is known after a message.

    Args:
        known: before it.
        message: from the topic of the ranges.
        oldest_ns: how old ranges may be; a sender that is silent for longer has gone.
        settings: how a scan is read.
        ages_backlogs: whether what it waited before its arrival counts.
    """
    try:
        ranged = decode_ranges(message, settings)
    except (UndecodableError, UnfitError) as error:
        return replace(known, fault=str(error))
    sender, before = ranged.stamp.sender, known.source
    source = bound_after(before, sender, ranged.received_ns, oldest_ns)
    if source.sender != sender:
        return replace(known, source=source)
    is_another = before is not None and before.sender != sender
    if known.fault or is_another or _is_newer(ranged, known.newest):
        backlog = NO_LAG
        if ages_backlogs:
            backlog = _aged(RangeState() if is_another else known, ranged, oldest_ns)
        return RangeState(ranged, source, backlog=backlog)
    return replace(known, source=source)


def _aged(known: RangeState, ranged: Ranged, silence_ns: int) -> Lag:
    """How far behind newly accepted ranges came."""
    stamp, newest = ranged.stamp, known.newest
    overtaken = newest is not None and stamp.sequence < newest.stamp.sequence
    return known.backlog.after(stamp.time_ns, ranged.received_ns, silence_ns, overtaken)


def _is_newer(ranged: Ranged, newest: Ranged | None) -> bool:
    if newest is None:
        return True
    this, last = ranged.stamp, newest.stamp
    return this.sequence > last.sequence or this.time_ns > last.time_ns


def lack_of(known: RangeState, now_ns: int, oldest_ns: int) -> str:
    """Why there are no ranges to go by, in words; empty if there are."""
    if known.fault:
        return f"no ranges: {known.fault}"
    if known.newest is None:
        return "no ranges yet"
    age_ns, behind_ns = now_ns - known.newest.received_ns, known.backlog.behind_ns
    if age_ns > oldest_ns:
        return f"no ranges for {age_ns * 1e-9:.1f} s"
    late = age_ns + behind_ns > oldest_ns
    return f"ranges {backlog_in_words(behind_ns)}" if late else ""


def beams_of(known: RangeState, now_ns: int, oldest_ns: int) -> Beams | None:
    """The beams to go by; None if there are none."""
    if known.newest is None or lack_of(known, now_ns, oldest_ns):
        return None
    return beams_of_scan(known.newest.scan)
