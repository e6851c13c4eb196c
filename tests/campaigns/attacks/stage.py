"""Where attacks take place: a real body on a free port, and a witness beside it."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from support.ros2_robot import free_port
from support.witness import Witness, body, runtime, witness

Bodies = Callable[..., AbstractContextManager[Any]]
"""Starts a body: called with a policy, a port, a folder and flags."""


@dataclass(frozen=True)
class Stage:
    """What every attack needs."""

    policy: Path
    folder: Path
    reflex: Path | None = None
    """A trained policy for the guard's attack; a hand-written one by default."""
    bodies: Bodies = body
    """By default, `reflexarc sim`; a test puts a gullible one here."""

    def place(self) -> tuple[int, Path]:
        """A port that nobody listens on, and an empty folder."""
        return free_port(), Path(mkdtemp(dir=self.folder))

    def empty_world(self) -> tuple[object, ...]:
        """Flags of a body in a world without obstacles: nothing but a command moves it."""
        world = self.folder / "reference-1-without-obstacles.toml"
        world.write_text('name = "no obstacles"\nlayers = []\nedges = "unbounded"\n')
        return ("--world", world)

    @contextmanager
    def standing(self, *words: object) -> Iterator["Scene"]:
        """A body without a runtime."""
        port, folder = self.place()
        with (
            self.bodies(self.policy, port, folder, *self.empty_world(), *words) as process,
            witness(port) as seen,
        ):
            seen.wait_for(lambda lease: True, "a body that speaks")
            yield Scene(self, port, folder, process, seen)

    @contextmanager
    def driving(self, *words: object) -> Iterator["Scene"]:
        """A body that a runtime drives; `words` are the runtime's flags."""
        with self.standing() as scene, scene.runtime(*words) as loop:
            scene.seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            yield replace(scene, loop=loop)


@dataclass(frozen=True)
class Scene:
    """A body, perhaps a runtime, and who watches both."""

    stage: Stage
    port: int
    folder: Path
    body: Any
    seen: Witness
    loop: Any = None

    def runtime(self, *words: object) -> AbstractContextManager[Any]:
        """A runtime for this body."""
        return runtime(self.stage.policy, self.port, self.folder, *words)
