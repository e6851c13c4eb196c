"""A node: any Python class with one method, named as `my.module:Class` or `FILE.py:Class`.

    class Controller:
        def on_message(self, topic, message, time_ns):
            return {"linear": {"x": 0.5}}

It is made anew for each log, without arguments. `time_ns` is the message's log time: a node that
asks another clock, or draws random numbers, does not say the same twice.
"""

import importlib
import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from reflexarc_runtime.errors import UsageError, first_line


class NodeError(UsageError):
    """A node that cannot be made or fed, or whose words are no messages of its topic."""


class NodeCrashError(Exception):
    """A node raised an error; its cause is that error."""


class AnyNode(Protocol):
    """What a class must have.

    Also `topics`, if it is to be given these alone; and `says`, a type of ROS 2 or a dictionary of
    types by topic, for dictionaries on a topic on which nothing was recorded yet.
    """

    def on_message(self, topic: str, message: Any, time_ns: int) -> Any:
        """Take a message.

        Args:
            topic: where it came: "/scan".
            message: of ROS 2 and of protobuf an object with the fields of its type, of JSON what
                `json.loads` makes of it, of anything else bytes.
            time_ns: its log time.

        Returns:
            What the node says: None, a message on its own topic, or any number of messages and of
            pairs (topic, message). A message is an object of its type, or a dictionary of those
            fields that are not zero.
        """
        ...


@dataclass(frozen=True)
class NamedNode:
    """A class, and the topic on which it speaks."""

    topic: str
    name: str
    """As it is named: `my.module:Controller`."""
    root: Path
    """Where files and modules are looked for."""
    own: frozenset[str] = frozenset()
    """All topics on which the class speaks: it is never given what was recorded there."""

    def make(self) -> AnyNode:
        """A new node.

        Raises:
            NodeError: there is no such class, or it cannot be made.
        """
        kind = self._class()
        try:
            node = kind()
        except Exception as error:
            raise NodeError(
                f"{self.name}: expected a class that is made without arguments, got "
                f"{type(error).__name__}: {first_line(error)}"
            ) from None
        if not callable(getattr(node, "on_message", None)):
            raise NodeError(f"{self.name}: expected a method on_message(topic, message, time_ns)")
        return node  # type: ignore[no-any-return]  # a class of the user's

    def _class(self) -> Callable[[], Any]:
        place, colon, name = self.name.rpartition(":")
        if not (colon and place and name.isidentifier()):
            raise NodeError(f"{self.name!r}: expected my.module:Class or FILE.py:Class")
        try:
            module = self._file(place) if place.endswith(".py") else _module(place, self.root)
        except Exception as error:  # whatever the user's module does when it is imported
            raise NodeError(
                f"{self.name}: {place} cannot be imported: {type(error).__name__}: "
                f"{first_line(error)}; modules are looked for in {self.root} and in pytest's "
                "`pythonpath`"
            ) from None
        found = getattr(module, name, None)
        if not callable(found):
            raise NodeError(f"{self.name}: there is no class {name} in {place}")
        return found  # type: ignore[no-any-return]  # of the user's

    def _file(self, place: str) -> ModuleType:
        path = self.root / place
        name = f"reflexarc_node_{path.stem}"
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:
            raise ImportError(f"{path} is no Python file")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # dataclasses look for it there
        spec.loader.exec_module(module)
        return module


def _module(name: str, root: Path) -> ModuleType:
    if str(root) not in sys.path:
        sys.path.append(str(root))  # behind all that is there
    return importlib.import_module(name)
