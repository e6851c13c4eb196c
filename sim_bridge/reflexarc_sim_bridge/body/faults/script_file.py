"""Fault scripts as files: TOML, read strictly.

seed = 17                 # of every draw
repeat_s = 5.0            # begin again after so long; 0 or absent: once

[[fault]]
kind = "delay"            # one of KINDS
begin_s = 1.0
duration_s = 0.5
delay_s = 0.3             # the kind's own fields
"""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_sim_bridge.body.faults.script import Fault, FaultScript


def read_script(path: Path) -> FaultScript:
    """Read a script from a TOML file.

    Raises:
        UsageError: the file cannot be read, or describes no valid script.
    """
    name = f"--faults: {path}"
    return parse_script(read_text(path, name), name)


def parse_script(text: str, name: str = "") -> FaultScript:
    """Read a script from TOML text.

    Args:
        text: the TOML.
        name: how complaints name it.

    Raises:
        UsageError: it is not TOML, or a field is missing, unknown, of the wrong type or out of
            range.
    """
    return fill(_File, TomlSource(text, name)).script


@dataclass(frozen=True)
class _File:
    """A script as its file says it: faults are single tables, each under [[fault]]."""

    fault: tuple[Fault, ...] = ()
    seed: int = 0
    repeat_s: float = 0.0

    def __post_init__(self) -> None:
        _ = self.script  # refuses what no script can say

    @property
    def script(self) -> FaultScript:
        return FaultScript(self.fault, self.seed, self.repeat_s)
