"""A project of golden logs, made by a new user from the wheel alone: what do its failures say?

    python tests/campaigns/golden_project.py [--python python3.12] [--wheel FILE] [--keep FOLDER]

Builds the wheel, makes an environment with it and pytest and nothing else, and a project outside
of the repository. Its `reflexarc` records two drives (only the bodies are of this environment, as
they need the extra `sim`) and cuts an incident out of one: three tests pass. Then, each by itself:
a policy that changed, one that was swapped inside a log, software that decides otherwise, in a
drive and in the incident, a log with a bit that fell over, one that was cut off. Each failure is
printed, each command that it names is typed as it stands. Exit status 1: an outcome was another
one, or a text lacks what its reader needs.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from reflexarc_runtime.messages_pb2 import Decision  # noqa: E402  # below its place
from support.fault_runs import free_ports  # noqa: E402
from support.processes import reflexarc, started  # noqa: E402
from support.rewriting import edit_decisions, flip_bit, rewrite  # noqa: E402

INI = '[tool.pytest.ini_options]\nreflexarc_logs = ["golden"]\n'
GOLDEN = Path("golden")
DRIVES = {"corridor.mcap": ("tier-30", 3), "a crowd.mcap": ("crossing", 7)}
"""What they are called, one of them as no shell likes it; in which world, with which seed."""
TICKS = 500
OTHER_TICK = 300
"""At which the software of now decides otherwise."""
OUR_WORDS = ("PYTHONPATH", "PYTEST_ADDOPTS", "VIRTUAL_ENV")
WHEN = r"tick \d+ \(\d+\.\d\d s\)"
ZSTD = bytes.fromhex("28b52ffd")
"""How what is compressed begins."""
FAILED = "1 failed, 2 passed"
LEADS = r"recorded: \w+ leads \w+ by [\d.e-]+; now \w+ leads \w+ by [\d.e-]+"
RETINA = r"left │[ ░▒▓█]+│ right"


@dataclass
class Project:
    """A folder outside of the repository, and the environment in which its owner types."""

    folder: Path
    environment: Path
    failures: list[str] = field(default_factory=list)

    def type(self, command: str) -> "subprocess.CompletedProcess[str]":
        """What its owner types, in a shell, in the project's folder."""
        settings = {name: value for name, value in os.environ.items() if name not in OUR_WORDS}
        settings["PATH"] = f"{self.environment / 'bin'}{os.pathsep}{settings['PATH']}"
        words = ["bash", "-c", command]
        return subprocess.run(
            words, cwd=self.folder, env=settings, capture_output=True, text=True, check=False
        )

    def expect(self, command: str, status: int, *patterns: str) -> str:
        """Type a command; what it says, which must match each pattern."""
        done = self.type(command)
        said = done.stdout + done.stderr
        print(f"$ {command}\n{said.rstrip()}\n[{done.returncode}]\n", flush=True)
        if done.returncode != status:
            self.failures.append(f"{command}: status {done.returncode}, expected {status}")
        for pattern in patterns:
            if not re.search(pattern, said):
                self.failures.append(f"{command}: its text lacks {pattern!r}")
        if str(self.folder) in "".join(re.findall(r"^(?!rootdir).*$", said, re.MULTILINE)):
            self.failures.append(f"{command}: its text has paths that nobody types")
        return said

    def follow(self, said: str, status: int, *patterns: str) -> None:
        """Type the next command that a failure names."""
        found = re.findall(r"^ *next: (.*)$|`(reflexarc .*?)`", said, re.MULTILINE)
        if not found:
            self.failures.append("a failure names no next command")
        for command in dict.fromkeys(one or other for one, other in found):
            self.expect(command, status, *patterns)


def main() -> int:
    """Make the project, break it, judge what is said."""
    given = _arguments()
    with tempfile.TemporaryDirectory() as name:
        place = (given.keep or Path(name)).resolve()
        place.mkdir(parents=True, exist_ok=True)
        environment = _environment(place / "env", given.python, given.wheel or _wheel())
        project = Project(place / "project", environment)
        _found(project, place)
        for case in (_policy, _swapped, _software, _incident, _damaged, _cut_off):
            with _golden_kept(project):
                print(f"--- {case.__doc__}\n")
                case(project)
    for failure in project.failures:
        print(f"WRONG  {failure}")
    print(f"{len(project.failures)} outcomes or texts are wrong")
    return int(bool(project.failures))


def _wheel() -> Path:
    subprocess.run(["make", "-s", "wheel", f"PYTHON={sys.executable}"], cwd=ROOT, check=True)
    return max((ROOT / "dist").glob("*.whl"), key=lambda path: path.stat().st_mtime)


def _environment(folder: Path, python: str, wheel: Path) -> Path:
    """What a robot needs, and pytest: no torch, no numba."""
    settings = {name: value for name, value in os.environ.items() if name not in OUR_WORDS}
    for words in (
        [python, "-m", "venv", folder],
        [folder / "bin/pip", "install", "--quiet", wheel, "pytest"],
    ):
        subprocess.run(list(map(str, words)), env=settings, check=True)
    return folder


def _found(project: Project, place: Path) -> None:
    """Two drives and an incident; all three pass."""
    (project.folder / GOLDEN).mkdir(parents=True)
    (project.folder / "pyproject.toml").write_text(INI)
    for seed in (0, 1):
        out = place / f"learned-{seed}"
        done = reflexarc("train", "--seed", seed, "--out", out)
        if done.returncode:
            raise SystemExit(done.stderr)
    shutil.copy(place / "learned-0/policy.onnx", project.folder / "policy.onnx")
    shutil.copy(place / "learned-1/policy.onnx", project.folder / "new.onnx")
    for name, (world, seed) in DRIVES.items():
        _drive(project, name, world, seed)
    first = shlex.quote(str(GOLDEN / "corridor.mcap"))
    command = f"reflexarc incident {first} --first contact -o {GOLDEN}/contact.mcap"
    project.expect(command, 0, "identical")
    project.expect("pytest", 0, "3 passed")


def _drive(project: Project, name: str, world: str, seed: int) -> None:
    (port,) = free_ports(1)
    body = ("--world", world, "--seed", seed, "--lockstep", "--steps", TICKS, "--port", port)
    with started("sim", *body, "--policy", project.folder / "policy.onnx"):
        log = shlex.quote(str(GOLDEN / name))
        flags = f"--lockstep --no-guard --ticks {TICKS} --port {port} --record {log}"
        project.expect(f"reflexarc run policy.onnx {flags}", 0)


def _policy(project: Project) -> None:
    """The policy changed."""
    limits = "--reflexarc-max-flips 2% --reflexarc-margin 0.001"
    margins = r"margin [\d.e-]+, the candidate's [\d.e-]+"
    texts = ("beyond its limits", WHEN, RETINA, margins)
    said = project.expect(f"pytest --reflexarc-policy new.onnx {limits}", 1, *texts)
    project.follow(said, 1, "flips")


def _swapped(project: Project) -> None:
    """Another policy was put into a log."""
    new = (project.folder / "new.onnx").read_bytes()
    _change(project, lambda old, log: rewrite(old, log, attachments={"policy.onnx": new}))
    said = project.expect("pytest", 1, FAILED, "is not the one that the log names")
    project.follow(said.replace("POLICY.onnx", "policy.onnx"), 0, "identical")


def _software(project: Project) -> None:
    """The software decides otherwise than it did."""

    def otherwise(decision: Decision) -> None:
        if decision.index == OTHER_TICK:
            _prefer_the_second(decision)

    _change(project, lambda old, log: rewrite(old, log, edit_decisions(otherwise)))
    when = rf"tick {OTHER_TICK} \(\d+\.\d\d s\) saw"
    said = project.expect("pytest", 1, FAILED, when, RETINA, LEADS)
    project.follow(said, 1, f"first divergence: tick {OTHER_TICK},")
    meant = re.findall(r"^ *if this is meant: (.*)$", said, re.MULTILINE)
    project.expect(*(meant or ["none"]), 0, "new baselines", "old: sha256", "new: sha256")
    project.expect("pytest", 0, "3 passed")


def _incident(project: Project) -> None:
    """The software decides otherwise in the incident."""
    edit = edit_decisions(_prefer_the_second)
    _change(project, lambda old, log: rewrite(old, log, edit), "contact.mcap")
    shows = "it shows contact at tick .* of corridor.mcap"
    said = project.expect("pytest", 1, FAILED, shows, WHEN, RETINA, LEADS)
    project.follow(said, 1, "first divergence")


def _prefer_the_second(decision: Decision) -> None:
    """Exchange the two largest Q-values."""
    if decision.q_values:
        values = decision.q_values
        first, second = sorted(range(len(values)), key=lambda i: -values[i])[:2]
        values[first], values[second] = values[second], values[first]
        decision.winner = second


def _damaged(project: Project) -> None:
    """A bit of a log fell over."""
    _change(project, lambda old, log: log.write_bytes(_fallen_over(old.read_bytes())))
    said = project.expect("pytest", 1, FAILED, "damaged: the CRC")
    project.follow(said, 1, "written +FIXED.mcap", "lost, middle")
    project.expect("reflexarc replay FIXED.mcap", 0, "identical")


def _fallen_over(log: bytes) -> bytes:
    """A bit in a chunk of messages: one in an index would harm nothing that replay reads."""
    return flip_bit(log, log.index(ZSTD, len(log) // 3) + 200)


def _cut_off(project: Project) -> None:
    """A log was cut off."""
    _change(project, lambda old, log: log.write_bytes(old.read_bytes()[:-50_000]))
    said = project.expect("pytest", 1, FAILED, "expected a finished log")
    project.follow(said, 1, "written +FIXED.mcap", "lost, end")
    project.expect("reflexarc replay FIXED.mcap", 0, "identical")


def _change(
    project: Project, change: Callable[[Path, Path], object], name: str = "a crowd.mcap"
) -> None:
    log = project.folder / GOLDEN / name
    old = log.with_suffix(".old")
    log.rename(old)
    change(old, log)
    old.unlink()


@contextmanager
def _golden_kept(project: Project) -> Iterator[None]:
    """Whatever is done to the logs is undone."""
    golden, kept = project.folder / GOLDEN, project.folder / "kept"
    shutil.copytree(golden, kept)
    try:
        yield
    finally:
        shutil.rmtree(golden)
        kept.rename(golden)
        (project.folder / "FIXED.mcap").unlink(missing_ok=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--python", default=sys.executable, help="what makes the environment")
    parser.add_argument("--wheel", type=Path, help="this one; by default it is built")
    parser.add_argument("--keep", type=Path, help="make it in this folder, and leave it there")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
