"""Sends a log, or the messages of a running robot, to a canvas."""

from typing import Protocol

from reflexarc_logs.reading.reader import Log, Record
from reflexarc_logs.viewing.drawer import Drawer
from reflexarc_logs.viewing.drawings import Drawing
from reflexarc_runtime.policy.policy import load_contract


class ViewerCanvas(Protocol):
    """Where things are drawn."""

    def at(self, time_ns: int, tick: int | None) -> None:
        """Set the time of what comes next: the wall clock, and the newest tick by then."""
        ...

    def draw(self, drawing: Drawing) -> None:
        """Draw it at that time."""
        ...

    def fix(self, drawing: Drawing) -> None:
        """Draw it for all times."""
        ...


def view_log(log: Log, canvas: ViewerCanvas) -> int:
    """Draw a whole log; returns how many of its messages a viewer can show.

    Raises:
        LogError: the log cannot be read.
    """
    drawer, shown = Drawer(), 0
    for record in log.records():
        name, payload = _name(log, record), record.payload
        shown += show(drawer, canvas, name, record.schema, payload, record.log_ns)
    if len(drawer.way().points_m):
        canvas.fix(drawer.way())
    return shown


def show(
    drawer: Drawer, canvas: ViewerCanvas, name: str, schema: str, payload: bytes, time_ns: int
) -> bool:
    """Draw one message; whether there is anything to see in it."""
    drawings = drawer.drawings(name, schema, payload)
    if drawings:
        canvas.at(time_ns, drawer.tick)
    for drawing in drawings:
        canvas.draw(drawing)
    return bool(drawings)


def action_names(policy: bytes | None) -> tuple[str, ...]:
    """The names of a policy's actions; none without a policy.

    Raises:
        PolicyError, ContractError: it is not intact.
    """
    if not policy:
        return ()
    return tuple(action.name for action in load_contract(policy, bounds=None).actions)


def _name(log: Log, record: Record) -> str:
    """Of the topic, without the robot's; of another robot's, whole."""
    return record.topic.removeprefix(f"/{log.run.robot}/").removeprefix("/")
