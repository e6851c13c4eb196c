"""Whether a candidate can be judged on a log: it has to see and to do what the recorded one did.

A log holds retinas and numbers of actions. A candidate with another eye would have seen something
else, and one whose action 1 is "right" where the recorded one's is "left" means something else by
the same number. Both would be judged wrongly, without a sign of it.
"""

import dataclasses
import json
from functools import lru_cache

from reflexarc_logs.judging.opposites import ways
from reflexarc_logs.reading.reader import Log
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import LogError, ReflexarcError
from reflexarc_runtime.policy.policy import load_contract
from reflexarc_runtime.words.suggestion import pasteable


def check_comparable(log: Log, candidate: PolicyContract) -> list[str]:
    """Compare the candidate's contract with the recorded policy's.

    Returns:
        What the reader should know.

    Raises:
        LogError: the candidate cannot be judged on this log.
    """
    recorded = _recorded_contract(log)
    if recorded is None:
        return ["the log does not say which eye and actions it was recorded with: taken for equal"]
    _check_eyes(log, recorded, candidate)
    _check_actions(log, recorded, candidate)
    return list(_other_differences(recorded, candidate))


def _recorded_contract(log: Log) -> PolicyContract | None:
    """That of the attached policy, or else of the configuration."""
    if log.policy is not None and (found := _contract_in(log.policy)) is not None:
        return found
    try:
        document = json.loads(log.config or b"null")
        return PolicyContract.from_json(json.dumps(document["contract"]))
    except (ValueError, TypeError, KeyError, RecursionError, ReflexarcError):
        return None


@lru_cache(maxsize=4)
def _contract_in(policy: bytes) -> PolicyContract | None:
    try:
        return load_contract(policy, bounds=None)
    except ReflexarcError:
        return None


def _check_eyes(log: Log, recorded: PolicyContract, candidate: PolicyContract) -> None:
    ours, theirs = dataclasses.asdict(candidate.retina), dataclasses.asdict(recorded.retina)
    other = [name for name in ours if ours[name] != theirs[name]]
    if other:
        said = ", ".join(f"{name} {theirs[name]} → {ours[name]}" for name in other)
        raise LogError(
            f"{log.path}: the candidate has another eye than the retinas were made with ({said}); "
            f"{_eyes_remedy(log)}"
        )


def _eyes_remedy(log: Log) -> str:
    """Only scans can be looked at again: a retina is what one eye made of the world."""
    if log.run.input == "scan":
        command = pasteable("reflexarc", "decide", log.path, "--policy", "CANDIDATE.onnx")
        return f"let it look for itself, at the scans: `{command} -o DECIDED.mcap`"
    return (
        "no other eye can look at recorded retinas: record a drive of its own with "
        "`reflexarc run`, or measure it with `reflexarc evaluate`"
    )


def _check_actions(log: Log, recorded: PolicyContract, candidate: PolicyContract) -> None:
    if list(map(ways, recorded.actions)) == list(map(ways, candidate.actions)):
        return
    told = [", ".join(map(_told, one.actions)) for one in (recorded, candidate)]
    raise LogError(
        f"{log.path}: the candidate's actions (linear, lateral, angular speed) go other ways than "
        f"the recorded ones: {told[0]} → {told[1]}; give a candidate with the same ones in the "
        "same order"
    )


def _told(action: Action) -> str:
    speeds = action.linear_mps, action.lateral_mps, action.angular_radps
    return f"{action.name} {' '.join(f'{speed:g}' for speed in speeds)}"


def _other_differences(recorded: PolicyContract, candidate: PolicyContract) -> list[str]:
    found = []
    if recorded.rate_hz != candidate.rate_hz:
        rates = f"{recorded.rate_hz:g} Hz, the candidate wants {candidate.rate_hz:g} Hz"
        found.append(f"recorded at {rates}")
    if _speeds(recorded) != _speeds(candidate):
        found.append("the candidate's actions have other speeds than the recorded ones")
    return found


def _speeds(contract: PolicyContract) -> list[tuple[float, float, float]]:
    return [(a.linear_mps, a.lateral_mps, a.angular_radps) for a in contract.actions]
