"""The service of a robot, kept running by whoever is asked to: a supervisor of ours, or systemd."""

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from campaigns.deaths.booted import BootedSystemd
from campaigns.deaths.systemd_service import SystemdService
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported
from support.processes import reflexarc
from support.service_life import Life
from support.supervisor import Supervisor

UNIT = "reflexarc-robot0.service"
STATE = "/var/lib/reflexarc-robot0"
SETTINGS = """\
policy = "policy.onnx"
port = {port}
no-guard = true
record = "{record}"
rotate-s = 60
keep-mb = {keep_mb}
"""
SAYS = "-m reflexarc run"
SUFFERS = "-m campaigns.ends.faulty run"
"""The same command, in which a signal can make the loop hang."""


class Service(Protocol):
    """A context manager: inside, a service is started again whenever it ends."""

    @property
    def lives(self) -> Sequence[Life]:
        """Its processes so far; only grows."""
        ...

    @property
    def gave_up(self) -> bool:
        """Whether it is not started again."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...


def followed_service(folder: Path, port: int, keep_mb: float) -> Service:
    """A service whose unit a supervisor follows; its policy and its logs are in `folder`."""
    _put_policy(folder)
    config = folder / "robot.toml"
    config.write_text(SETTINGS.format(port=port, keep_mb=keep_mb, record="logs"))
    shown = reflexarc("service", "show", config)
    assert SAYS in shown.stdout, shown.stderr
    return Supervisor(shown.stdout.replace(SAYS, SUFFERS), folder)


def systemd_service(system: BootedSystemd, folder: Path, port: int, keep_mb: float) -> Service:
    """A service under a booted systemd; at its end its logs are copied to `folder`."""
    python = system.make_environment()
    place = system.path("/etc/reflexarc")
    for each in (folder, place):
        _put_policy(each)
    config = SETTINGS.format(port=port, keep_mb=keep_mb, record=f"{STATE}/logs")
    (place / "robot.toml").write_text(config)
    installed = system.runs(
        python, "-m", "reflexarc", "service", "install", "/etc/reflexarc/robot.toml"
    )
    unit = system.path(f"/etc/systemd/system/{UNIT}")
    assert installed.returncode == 0, installed.stderr
    unit.write_text(unit.read_text().replace(SAYS, SUFFERS))
    return SystemdService(system, UNIT, f"{STATE}/logs", folder / "logs")


def _put_policy(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "policy.onnx").write_bytes(exported(PolicyContract()))
