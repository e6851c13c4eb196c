"""What `recover` saved and what it did not, in words."""

from collections.abc import Sequence

from rich.table import Table

from reflexarc.terminal.output import facts, kibibytes, plain
from reflexarc_logs.reading.losses import LossPlace, LostPart
from reflexarc_logs.reading.recover import Recovered

NOTHING = "nothing"
MOST_TOLD = 5


def describe_recovery(recovered: Recovered) -> Table:
    """All that a person should know before the broken log is thrown away."""
    rows = {"messages": str(recovered.messages), **_lost(recovered)}
    if recovered.nameless_channels:
        rows["without a name"] = (
            f"{recovered.nameless_channels} channels, as /recovered/channel-N: "
            "their messages are kept, their topics are lost"
        )
    if recovered.doubt:
        rows["in doubt"] = plain(recovered.doubt)
    if not recovered.is_ours:
        rows["log"] = "of another system; its records are kept as they are"
    return facts({**rows, "written": plain(str(recovered.path))})


def _lost(recovered: Recovered) -> dict[str, str]:
    if not recovered.losses:
        return {"lost": NOTHING}
    rows = {}
    for place in LossPlace:
        here = [loss for loss in recovered.losses if loss.place is place]
        if here or place is not LossPlace.UNKNOWN:
            rows[_name(place)] = _told(here)
    if recovered.lost_by_topic:
        topics = recovered.lost_by_topic.items()
        rows["lost by topic"] = ", ".join(f"{plain(topic)} {count}" for topic, count in topics)
    return rows


def _name(place: LossPlace) -> str:
    return place.value if place is LossPlace.BEHIND else f"lost, {place.value}"


def _told(losses: Sequence[LostPart]) -> str:
    if len(losses) > MOST_TOLD:
        size = kibibytes(sum(loss.bytes for loss in losses))
        return f"{len(losses)} parts, {size}; --json lists them"
    return "; ".join(map(_one, losses)) or NOTHING


def _one(loss: LostPart) -> str:
    count = "an unknown number of messages" if loss.messages is None else _messages(loss.messages)
    size = f", {kibibytes(loss.bytes)}" if loss.bytes else ""
    if loss.place is LossPlace.BEHIND:
        return f"{plain(loss.what)}{size}"
    return f"{count}: {plain(loss.what)}{size}"


def _messages(count: int) -> str:
    return "1 message" if count == 1 else f"{count} messages"
