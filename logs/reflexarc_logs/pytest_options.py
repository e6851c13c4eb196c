"""The options of the pytest plugin: whose decisions a log is compared with, and how strictly.

    [tool.pytest.ini_options]
    reflexarc_logs = ["tests/golden"]
    reflexarc_policy = "policies/candidate.onnx"
    reflexarc_max_flips = "5%"
    reflexarc_margin = "0.02"

Each is also an option of the command line (`--reflexarc-max-flips 5%`), which goes before. Limits
in the ini file wait for a policy; on the command line they want one. `--reflexarc-update` exists on
the command line only: a new baseline is accepted by hand.
"""

from dataclasses import dataclass
from pathlib import Path

import pytest

UPDATE = "--reflexarc-update"
_POLICY = "policy"
_LIMITS = {
    "max_flips": "most flips of a log: a count, or a share of its ticks, as 5%%",
    "max_reversals": "most flips of a log to the opposite action",
    "margin": "flips whose recorded Q-values lie closer do not count",
    "from": "first tick that counts, or seconds since the log's first tick, as 50 or 2.4s",
    "to": "tick before which counting ends, or seconds",
}
"""The options, as they end in the ini file, with their help."""


class OptionError(Exception):
    """An option that cannot be meant."""


@dataclass(frozen=True)
class LogOptions:
    """What was asked for, in words as they were given."""

    policy: Path | None
    """The candidate's file; None: each log is compared with the policy that it carries."""
    limits: dict[str, str]
    """By their names in the ini file; empty without a policy."""
    update: bool
    """Whether the decisions of now are accepted as the new baseline."""


def add_options(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("reflexarc", "logs as tests")
    helps = {_POLICY: "judge this policy on the logs, in the place of the software", **_LIMITS}
    for name, text in helps.items():
        parser.addini(f"reflexarc_{name}", text.replace("%%", "%"), "string", "")
        group.addoption(_flag(name), dest=f"reflexarc_{name}", default=None, help=text)
    text = "replace each log that differs by one with the decisions of now, and show both"
    group.addoption(UPDATE, action="store_true", dest="reflexarc_update", help=text)


def log_options(config: pytest.Config) -> LogOptions:
    """What this run asks for.

    Raises:
        OptionError: limits on the command line without a policy, a policy that is not there, or an
            update that nobody typed.
    """
    policy = _policy(config)
    typed = [name for name in _LIMITS if config.getoption(f"reflexarc_{name}") is not None]
    if policy is None and typed:
        raise OptionError(f"{_flag(typed[0])}: limits judge a candidate; give {_flag(_POLICY)}")
    words = {name: _word(config, name) for name in _LIMITS} if policy is not None else {}
    update = bool(config.getoption("reflexarc_update"))
    if update and not _is_typed(config):
        raise OptionError(f"{UPDATE}: by hand only, on the command line; not in addopts")
    return LogOptions(policy, {name: word for name, word in words.items() if word}, update)


def _policy(config: pytest.Config) -> Path | None:
    typed = config.getoption("reflexarc_policy")
    word = _word(config, _POLICY)
    if not word:
        return None
    path = (config.rootpath if typed is None else config.invocation_params.dir) / word
    if not path.is_file():
        raise OptionError(f"reflexarc_policy: {word}: there is no such file")
    return path


def _word(config: pytest.Config, name: str) -> str:
    typed = config.getoption(f"reflexarc_{name}")
    return str(config.getini(f"reflexarc_{name}") if typed is None else typed).strip()


def _is_typed(config: pytest.Config) -> bool:
    """Whether somebody typed the update; a worker of pytest-xdist is told by who did."""
    return hasattr(config, "workerinput") or UPDATE in config.invocation_params.args


def _flag(name: str) -> str:
    return f"--reflexarc-{name.replace('_', '-')}"
