"""The fleet as plain values with units in their names: what `reflexarc top --json` prints."""

from typing import Any

from reflexarc_runtime.fleet.views import BodyView, FleetView, RobotView, RuntimeView
from reflexarc_runtime.messages.spread import Spread
from reflexarc_runtime.messages.wire import NO_SENDER

SHOWN_ID = 8
"""Characters of an identifier that are shown, as everywhere."""


def fleet_as_dict(fleet: FleetView) -> dict[str, Any]:
    """Every robot, and what they are together."""
    return {
        "robots": [_robot(each) for each in fleet.robots],
        "totals": totals(fleet),
    }


def totals(fleet: FleetView) -> dict[str, Any]:
    """What all robots are together; nodes that have fallen silent are in `silent` alone."""
    runtimes, bodies = fleet.runtimes, fleet.bodies
    return {
        "robots": len(fleet.robots),
        "runtimes": len(runtimes),
        "bodies": len(bodies),
        "armed": sum(each.lease is not None and each.lease.armed for each in bodies),
        "holding": sum(each.holds_lease for each in runtimes),
        "rate_hz": round(sum(each.said.rate_hz or 0.0 for each in runtimes), 3),
        "silent": fleet.silent,
        "unreadable": fleet.unreadable,
        "left_out": fleet.left_out,
    }


def shown_id(sender: bytes) -> str:
    """An identifier as it is shown; empty: nobody's."""
    return "" if sender in (b"", NO_SENDER) else sender.hex()[:SHOWN_ID]


def _robot(robot: RobotView) -> dict[str, Any]:
    return {
        "robot": robot.robot,
        "nodes": list(robot.nodes),
        "runtimes": [_runtime(each) for each in robot.runtimes],
        "bodies": [_body(each) for each in robot.bodies],
    }


def _runtime(runtime: RuntimeView) -> dict[str, Any]:
    said = runtime.said
    return {
        "id": shown_id(runtime.sender),
        "run_id": said.run_id,
        "age_s": round(runtime.age_s, 3),
        "state": _state(runtime.is_silent),
        "holds_lease": runtime.holds_lease,
        "rate_hz": None if said.rate_hz is None else round(said.rate_hz, 3),
        "contract_rate_hz": said.contract_rate_hz,
        "pace": said.pace,
        "ticks": said.ticks,
        "skipped_slots": said.skipped_slots,
        "inbox_overflows": said.inbox_overflows,
        "verdict": said.verdict,
        "verdicts": dict(said.verdicts),
        "period_verdicts": runtime.period_verdicts,
        "action": said.action,
        "policy": said.policy,
        "policy_hash": said.policy_hash,
        "guard": said.guard,
        "recording": said.recording,
        "watchdog": said.watchdog,
        "sensor": said.sensor,
        "shadow": said.shadow,
        "phases": {name.replace(" ", "_"): _times(each) for name, each in said.phases.items()},
    }


def _body(body: BodyView) -> dict[str, Any]:
    lease = body.lease
    return {
        "id": shown_id(body.sender),
        "age_s": round(body.age_s, 3),
        "state": _state(body.is_silent),
        "lease": None if lease is None else lease.words,
        "holder": None if lease is None else shown_id(lease.holder),
        "epoch": None if lease is None else lease.epoch,
        "armed": None if lease is None else lease.armed,
        "stopped": None if lease is None else lease.stopped,
        "refused": None if lease is None else dict(lease.refused),
        "guard": body.said.guard,
    }


def _state(is_silent: bool) -> str:
    return "silent" if is_silent else "live"


def _seconds(time_ns: int) -> float:
    return round(time_ns * 1e-9, 9)


def _times(spread: Spread) -> dict[str, float]:
    return {
        "count": spread.count,
        "p50_s": _seconds(spread.p50_ns),
        "p99_s": _seconds(spread.p99_ns),
        "p999_s": _seconds(spread.p999_ns),
        "max_s": _seconds(spread.max_ns),
    }
