"""What became of every topic of a log: compared, an input of what was compared, or neither."""

from collections.abc import Iterator

from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.loop_events import beside_the_sensor
from reflexarc_logs.replaying.report import StreamUse
from reflexarc_logs.replaying.robot_replay import RobotFindings
from reflexarc_runtime.messages.topics import COMMAND, KEYFRAME, REJECTED, SENSORS, SHADOW, TICK

COMPARED, INPUT, NOT_COMPARED = "compared", "input", "not compared"


def stream_uses(account: LogAccount, found: RobotFindings) -> Iterator[StreamUse]:
    """Every topic of a log, sorted.

    Args:
        account: of the whole log.
        found: in the replay of its robots.
    """
    log = account.log
    used = {
        f"/{robot}/{topic.name}": (topic.schema, COMPARED)
        for robot in found.robots
        for topic in (TICK, COMMAND)
    }
    for robot in found.keyed:
        used[f"/{robot}/{KEYFRAME.name}"] = KEYFRAME.schema, COMPARED
    for robot in found.shadowed:
        used[f"/{robot}/{SHADOW.name}"] = SHADOW.schema, COMPARED
    for robot in found.stepped:
        for topic in (SENSORS[log.run.input], *beside_the_sensor(log), REJECTED):
            used[f"/{robot}/{topic.name}"] = topic.schema, INPUT
    for (name, schema), messages in sorted(account.streams.items()):
        expected, use = used.get(name, ("", NOT_COMPARED))
        yield StreamUse(name, schema, messages, use if schema == expected else NOT_COMPARED)
