"""A policy in words and tables: what it sees, what it does, how fast, and where it comes from."""

from pathlib import Path

from rich.console import Group
from rich.table import Table

from reflexarc.terminal.body_words import body_words
from reflexarc.terminal.output import facts, plain
from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.bounds import excesses
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.policy.policy import USUAL_BOUNDS, LoadedPolicy

SHOWN_HASH = 12

_NAME_WIDTH = len("golden vectors")
_BEAMS = {
    BeamRule.NEAREST_BEAM: "of a scan, a ray takes the one nearest to its bearing",
    BeamRule.SECTOR_MINIMUM: "of a scan, a ray takes the nearest return in its sector",
}


def describe_policy(path: Path, policy: LoadedPolicy) -> Group:
    """All that a person should know before a robot is driven by a policy."""
    contract = policy.contract
    file = {"policy": plain(str(path)), "hash": policy.policy_hash, "digest": _digest(policy)}
    lived = {**_eye(contract.retina), **_pace(contract), **_body(contract.body)}
    return Group(
        facts({**file, **lived}, name_width=_NAME_WIDTH),
        _motions(contract),
        facts({**_warning(contract), **_origin(contract)}, name_width=_NAME_WIDTH),
    )


def _digest(policy: LoadedPolicy) -> str:
    """The digest in short, or why there is none."""
    return f"{policy.digest[:SHOWN_HASH]}…" if policy.digest else "; ".join(policy.notes)


def _eye(eye: RetinaSpec) -> dict[str, str]:
    apart = f" {eye.baseline_m:g} m apart" if eye.eyes > 1 else ""
    sees = (
        f"{_count(eye.eyes, 'eye')}{apart}, {_count(eye.rays, 'ray')} over {eye.fov_rad:.3f} rad, "
        f"{eye.range_m:g} m, {eye.shading}, {_count(eye.channels, 'channel')}, "
        f"{_count(eye.frames, 'frame')}"
    )
    return {"sees": sees, "beams": _BEAMS[eye.beams]}


def _pace(contract: PolicyContract) -> dict[str, str]:
    hold_s, slots = contract.hold_s, contract.hold_slots
    memory = contract.state.size
    return {
        "rate": f"{contract.rate_hz:g} Hz",
        "inputs": f"at most {contract.max_input_age_s:g} s old; "
        f"{contract.recovery_inputs} good in a row before it drives",
        "hold": f"{hold_s:g} s, {_count(slots, 'tick')}" if slots else "none",
        "margin": _margin(contract),
        "memory": _count(memory, "value") if memory else "none",
        "backends": f"agree to {contract.q_tolerance:g} × max(1, |Q|)",
    }


def _margin(contract: PolicyContract) -> str:
    """By how much another action must win over the one that is being done."""
    share, lead = contract.margin, contract.least_lead
    words = [f"{share:g} of the Q-values' spread"] if share else []
    return " and ".join([*words, *([f"{lead:g} in Q"] if lead else [])]) or "none"


def _body(body: BodySpec) -> dict[str, str]:
    words = body_words(body.footprint, body.actuation_delay_s, body.deceleration_mps2)
    return {"body": words.outline, "obeys": words.obeys, "stops": words.stops}


def _motions(contract: PolicyContract) -> Table:
    """Every action with its three speeds, and what is sent when it must not drive."""
    table = Table()
    table.add_column("action", overflow="fold")
    for name in ("ahead", "to the left", "turn left"):
        table.add_column(name, justify="right", no_wrap=True)
    for action in contract.actions:
        table.add_row(*_motion(action))
    table.add_section()
    name, *speeds = _motion(contract.safe_command)
    table.add_row(f"{name} (the safe command)", *speeds)
    return table


def _motion(action: Action) -> tuple[str, str, str, str]:
    return (
        plain(action.name),
        f"{action.linear_mps:g} m/s",
        f"{action.lateral_mps:g} m/s",
        f"{action.angular_radps:g} rad/s",
    )


def _warning(contract: PolicyContract) -> dict[str, str]:
    """What `run` refuses without a flag, if there is anything."""
    beyond = [plain(excess) for excess in excesses(contract, USUAL_BOUNDS)]
    return {"beyond bounds": "\n".join(beyond)} if beyond else {}


def _origin(contract: PolicyContract) -> dict[str, object]:
    origin: Provenance = contract.provenance
    return {
        "learned as": f"preset {plain(origin.preset) or 'unknown'}, seed {origin.seed}, "
        f"configuration {plain(origin.config_hash[:SHOWN_HASH]) or 'unknown'}",
        "commit": plain(origin.commit) or "unknown",
        "scores": ", ".join(f"{plain(k)} {v:g}" for k, v in origin.scores.items()) or "none",
        "golden vectors": _golden(contract),
    }


def _golden(contract: PolicyContract) -> str:
    vectors, sequences = len(contract.golden.retinas), len(contract.golden.sequences)
    return f"{vectors}, and {_count(sequences, 'sequence')}" if sequences else str(vectors)


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
