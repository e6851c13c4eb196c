"""A robot as its own log has it, for whoever judges what was seen of it."""

from pathlib import Path

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import ReflexarcError
from support.fleet_judge import LoggedRobot


def logged_robot(path: Path) -> LoggedRobot:
    """Read what a log says of its robot, tick by tick."""
    log = read_log(path)
    ticks = list(log.ticks())
    return LoggedRobot(
        log.run.robot,
        [tick.decision.now_ns - tick.timing.receive_ns for tick in ticks],
        [Verdict(tick.decision.verdict).name for tick in ticks],
        [tick.decision.policy_hash for tick in ticks],
        [tick.decision.slot for tick in ticks],
        _leases(log),
    )


def _leases(log: Log) -> list[tuple[int, str]]:
    offset_ns = log.run.wall_offset_ns
    return [
        (record.log_ns - offset_ns, lease.holder.hex())
        for record, lease in log.messages(log.topic("lease"), pb.Lease)
    ]


def fault_of(path: Path, levels: frozenset[str] = frozenset({"policy", "node"})) -> str:
    """Why a log does not replay identically at these levels; empty: it does."""
    try:
        report = replay(path)
    except ReflexarcError as error:
        return f"{path.name}: {error}"
    found = {level.level for level in report.levels}
    if report.exit_status == 0 and report.verdict == "identical" and levels <= found:
        return ""
    return f"{path.name}: {report.verdict}, levels {sorted(found)}: {report.lines()[:3]}"
