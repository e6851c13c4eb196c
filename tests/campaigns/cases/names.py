"""Words out of a file, and the names of files, are no markup."""

import shutil
import subprocess
import sys
from pathlib import Path

from cases.case import Case, Outcome, Stage

GOLDEN = Path(__file__).parents[2] / "golden" / "nominal.mcap"
ESCAPE = "\x1b"


def brackets_in_a_topic(stage: Stage) -> Outcome:
    """A topic of ROS with brackets."""
    said = stage.reflexarc("info", stage.inputs / "topic-with-brackets.mcap")
    holds = said.status == 0 and "/camera[/left]/image" in said.out
    return Outcome(holds, f"status {said.status}")


def named(name: str, stage: Stage) -> Path:
    """A log of this name."""
    path = stage.scratch / name
    path.parent.mkdir(exist_ok=True)
    shutil.copy(GOLDEN, path)
    return path


def shown_as_it_is(stage: Stage) -> Outcome:
    """A log whose name begins with a tag."""
    said = stage.reflexarc("info", named("[red]drive.mcap", stage).name)
    return Outcome("[red]drive.mcap" in said.out, said.out.splitlines()[0])


def recovered_into_brackets(stage: Stage) -> Outcome:
    """`recover` into a folder with brackets, and the command that it suggests, pasted."""
    log = named("a.mcap", stage)
    (stage.scratch / "run[" / "3]").mkdir(parents=True)
    said = stage.reflexarc("recover", log, "-o", "run[/3]/x y.mcap")
    line = next((line for line in said.complaint.splitlines() if "try: " in line), "")
    again = line.partition("try: reflexarc ")[2]
    script = f"{sys.executable} -m reflexarc {again}"
    pasted = subprocess.run(
        ["bash", "-c", script], cwd=stage.scratch, capture_output=True, text=True, check=False
    )
    holds = said.status == 0 and not said.has_traceback and pasted.returncode == 0
    return Outcome(holds, f"status {said.status}, pasted {pasted.returncode}: {again}")


def drawn_with_dollars(stage: Stage) -> Outcome:
    r"""`render` of `a$\foo$.mcap`."""
    said = stage.reflexarc("render", named(r"a$\foo$.mcap", stage).name, "-o", "x.png")
    drawn = (stage.scratch / "x.png").exists()
    return Outcome(said.status == 0 and drawn, f"status {said.status}, drawn {drawn}")


def escapes_in_a_name(stage: Stage) -> Outcome:
    """Terminal escapes, halves of characters and a newline in a name, in every command on logs."""
    name = f"{ESCAPE}[31m\udcff\n.mcap"
    log = named(name, stage).name
    words = {
        "info": (log,),
        "replay": (log,),
        "recover": (log, "-o", f"2{name}"),
        "cut": (log, "--from", 1, "--to", 9, "-o", f"3{name}"),
        "render": (log, "-o", "y.png"),
        "play": (log, "--speed", 1000, "--port", 7999),
        "import": ("carmen", log, "-o", f"4{name}"),
    }
    said = {command: stage.reflexarc(command, *rest) for command, rest in words.items()}
    bad = [c for c, s in said.items() if s.has_traceback or ESCAPE in s.everything]
    status = {command: each.status for command, each in said.items()}
    return Outcome(not bad, f"status {status}, bad {bad}")


def from_windows(stage: Stage) -> Outcome:
    """A calibration with a byte order mark and CRLF: beside a policy that sees distances."""
    shutil.copy(stage.inputs / "calibration.toml", stage.scratch)
    script = (
        "from pathlib import Path;"
        "from reflexarc_sim_bridge.body.camera.calibration import read_calibration as read;"
        "print(read(Path('calibration.toml')).band)"
    )
    said = stage.command(sys.executable, "-c", script)
    holds = said.status == 0 and "top=0.2, bottom=0.9" in said.out
    return Outcome(holds, (said.out or said.complaint).strip()[-200:])


CASES: tuple[Case, ...] = (
    Case("markup", "topic with brackets", "shown as it is", brackets_in_a_topic),
    Case("markup", "[red]drive.mcap", "shown as it is", shown_as_it_is),
    Case("markup", "recover into run[/3]", "no traceback; pasted", recovered_into_brackets),
    Case("markup", "render of a$\\foo$.mcap", "a picture", drawn_with_dollars),
    Case("markup", "escapes in a name", "escaped, no traceback", escapes_in_a_name),
    Case("toml-bom", "BOM and CRLF", "read", from_windows),
)
