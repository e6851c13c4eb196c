"""Replay at level `node`: the inputs of each tick through the controller, every field compared.

Each tick takes its `inputs` next messages in file order; no time stamp decides what belongs to
which tick. What is missing is left out (`walk`), never called different. Where the log has a
keyframe, what the controller knows is compared with it. Timing is never compared.
"""

from reflexarc_logs.container.run_info import LOOPS
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import begin
from reflexarc_logs.replaying.comparison import EqualityRules, Tally
from reflexarc_logs.replaying.loop_events import beside_the_sensor, loop_events
from reflexarc_logs.replaying.report import LevelResult
from reflexarc_logs.replaying.runs.asked_ahead import asked_ahead
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.walk import Walk
from reflexarc_runtime.messages.topics import REJECTED, SENSORS
from reflexarc_runtime.policy.policy import LoadedPolicy

GIVEN = ("slot", "now_ns")
"""When a tick was is no decision: of its time only the ages that follow from it are compared."""


def replay_node(
    log: Log,
    policy: LoadedPolicy,
    rules: EqualityRules,
    robot: str = "",
    served: ServedPolicies | None = None,
) -> tuple[LevelResult, list[str]]:
    """Step a controller through the log.

    Args:
        log: what a loop recorded.
        policy: whom to ask.
        rules: what counts as equal.
        robot: see `LevelResult.robot`.
        served: who took over; by default, as the log says.

    Returns:
        The result, and what its reader should know.

    Raises:
        LogError: the log cannot be read, or was not recorded by a loop.
    """
    asked, read = asked_ahead(policy, loop_events(log))
    served = served or ServedPolicies(log, policy)
    beginning, events = begin(log, read, asked, served)
    tally = Tally("node", rules, ticks=beginning.skipped_ticks, robot=robot)
    walk = Walk(log, asked, beginning, rules, tally)
    for event in events:
        walk.take(event)
    notes = [*filter(None, [beginning.note]), *walk.end()]
    return tally.result(walk.stepping.fields.not_compared, GIVEN), notes


def why_not(log: Log) -> str:
    """What keeps a log from being replayed at level `node`; empty if nothing does."""
    if log.run.recorded_by == "import":
        return "it was imported from another system; no loop of ours decided on it"
    if log.run.recorded_by not in LOOPS:
        return "it was recorded by a listener, whose order is not the loop's"
    if log.dropped:
        return f"{log.dropped} records or chunks are missing in its middle"
    sensor = log.topic(SENSORS[log.run.input].name)
    stream = next(log.records(sensor, log.topic(REJECTED.name)), None)
    if stream is None and _inputs_taken(log) > _others(log):
        return f"it has no sensor stream ({sensor})"
    return ""


def _inputs_taken(log: Log) -> int:
    return sum(tick.decision.inputs for tick in log.ticks())


def _others(log: Log) -> int:
    """Stops, resets, a guard's own ranges: inputs that are not what it decided on."""
    topics = (log.topic(topic.name) for topic in beside_the_sensor(log))
    return sum(1 for _ in log.records(*topics))
