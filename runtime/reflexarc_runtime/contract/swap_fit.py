"""May one policy take over from another while a robot is in service?

What others were built by must be the same: the body's eye, the loop's rate, how long a command
counts, the safe command that a watchdog says, the names by which logs and people know the actions,
and how much is remembered. How fast the actions are, how long they are held, and what it learned
is its own.
"""

from collections.abc import Iterator

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_runtime.errors import ContractError


def check_takes_over(candidate: PolicyContract, running: PolicyContract) -> None:
    """Refuse a policy that cannot take over from the one that runs.

    Raises:
        ContractError: each thing in which they differ, as running → candidate.
    """
    differences = list(_differences(candidate, running))
    if differences:
        raise ContractError(
            f"expected a policy that fits the running one, got another contract: "
            f"{'; '.join(differences)}; end the runtime and start it with this policy"
        )


def _differences(candidate: PolicyContract, running: PolicyContract) -> Iterator[str]:
    pairs = {
        "eye": (eye_in_words(running.retina), eye_in_words(candidate.retina)),
        "frames": (running.retina.frames, candidate.retina.frames),
        "rate_hz": (running.rate_hz, candidate.rate_hz),
        "max_input_age_s": (running.max_input_age_s, candidate.max_input_age_s),
        "actions": (_names(running), _names(candidate)),
        "safe_command": (running.safe_command, candidate.safe_command),
        "values remembered": (running.state.size, candidate.state.size),
        "body": (running.body, candidate.body),
    }
    for name, (ours, theirs) in pairs.items():
        if ours != theirs:
            yield f"{name}: {ours} → {theirs}"


def _names(contract: PolicyContract) -> str:
    return ", ".join(action.name for action in contract.actions)
