"""A process that tries mutants on what the commands call: see `mutants.py`.

It makes each mutant from its number alone. It ends itself after a minute of the processor at one
mutant, and cannot have much more memory than it began with.
"""

import contextlib
import io
import random
import resource
import signal
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hostile.good_files import Good, good_files
from hostile.mutations import mutated
from reflexarc.main import main as reflexarc
from reflexarc_runtime.crew.worker import serve
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.body.camera.sources import source_named
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_ALONE_S = 60
_MOST_S, _MOST_BYTES = 10.0, 500 << 20
_ADDRESS_SPACE = 1 << 30
"""Beyond that of the process as it begins: room for the caches and arenas of libraries, too."""
_FRAMES = 3
_BROKEN, _REFUSED, _TAKEN = "broken", "refused", "taken"


def main() -> None:
    """Serve, in a folder of its own."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        good = good_files(folder)
        for one in good:
            found = _tried(one, one.data, one.ways[0], folder)
            assert found["how"] == _TAKEN, (one.name, found)
        _limit_memory()
        serve(lambda plain: _task(plain, good, folder), "good files")


def _task(plain: dict[str, Any], good: list[Good], folder: Path) -> dict[str, Any]:
    number = int(plain["number"])
    dice = random.Random(number)
    chosen = good[number % len(good)]
    data = mutated(chosen.data, dice, is_text=chosen.is_text)
    way = dice.choice(chosen.ways)
    found = _tried(chosen, data, way, folder)
    if found["how"] == _BROKEN or found["faults"]:
        (Path(plain["kept"]) / f"{number}-{chosen.name}").write_bytes(data)
    return {"number": number, "file": chosen.name, "way": way, **found}


def _tried(one: Good, data: bytes, way: str, folder: Path) -> dict[str, Any]:
    """How one way of using a file ended, and what it took."""
    path, out = folder / one.name, folder / "out"
    path.write_bytes(data)
    words = [w.replace("FILE", str(path)).replace("OUT", str(out)) for w in way.split()]
    _forget_peak()
    signal.setitimer(signal.ITIMER_PROF, _ALONE_S)  # of the processor, which others use as well
    began_s = time.process_time()
    try:
        how, said = _USES.get(words[0], _command)(words)
    except Exception:
        how, said = _BROKEN, traceback.format_exc()[-1500:]
    took_s = time.process_time() - began_s
    signal.setitimer(signal.ITIMER_PROF, 0)
    for left in folder.glob("out*"):
        left.unlink()
    peak = _peak_bytes()
    wrong = {"slow": took_s > _MOST_S, "large": peak > _MOST_BYTES}
    faults = [name for name, holds in wrong.items() if holds]
    return {"how": how, "said": said, "took_s": took_s, "peak": peak, "faults": faults}


def _command(words: list[str]) -> tuple[str, str]:
    out, complaint = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(complaint):
        status = reflexarc(words)
    lines = [line for line in complaint.getvalue().splitlines() if line.strip()]
    if status not in (0, 1, 2) or (status == 2 and len(lines) != 1):
        return _BROKEN, f"status {status}: {complaint.getvalue()[-1500:]}"
    return (_REFUSED if status == 2 else _TAKEN), lines[-1] if lines else ""


def _in_one_line(use: Callable[[Path], None]) -> Callable[[list[str]], tuple[str, str]]:
    """A use that ends well, or with an error of one line."""

    def used(words: list[str]) -> tuple[str, str]:
        try:
            use(Path(words[1]))
        except ReflexarcError as error:
            return (_BROKEN if "\n" in str(error) else _REFUSED), str(error)
        except OSError as error:  # the command line makes one line of it
            return _REFUSED, str(error)
        return _TAKEN, ""

    return used


def _live_in_world(path: Path) -> None:
    world = world_named(str(path))
    simulation = Simulation(world, reference_contract(), np.arange(4, dtype=np.uint64))
    for _ in range(5):
        simulation.sense()
        simulation.step(np.zeros(4, np.int64))


def _look_at(path: Path) -> None:
    source = source_named(str(path), 10.0, None, lambda _: None)
    for _, _image in zip(range(_FRAMES), source.frames(), strict=False):
        pass


_USES = {"live": _in_one_line(_live_in_world), "look": _in_one_line(_look_at)}


def _limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + _ADDRESS_SPACE
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))


def _forget_peak() -> None:
    """Let the kernel count the largest memory from here on."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _peak_bytes() -> int:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))


if __name__ == "__main__":
    main()
