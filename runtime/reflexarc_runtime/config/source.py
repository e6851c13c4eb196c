"""Documents that dataclasses are filled from, and how each says what is wrong with it.

`MappingSource` holds what JSON, metadata or settings gave, and names the path of a field.
`TomlSource` (toml_source.py) holds the text of a file, and names the line as well.
"""

from collections.abc import Mapping
from typing import Protocol

from reflexarc_runtime.config.key_path import KeyPath, dotted
from reflexarc_runtime.errors import ReflexarcError, UsageError


class Source(Protocol):
    """A document, and the words for what is wrong with a place in it."""

    @property
    def document(self) -> Mapping[str, object]:
        """What it says."""
        ...

    def complaint(self, path: KeyPath, words: str) -> ReflexarcError:
        """The error for what stands at a path."""
        ...

    def one_table(self, path: KeyPath) -> str:
        """What a dataclass is filled from, in the words of the format: "a table, [lens]"."""
        ...

    def many_tables(self, path: KeyPath) -> str:
        """What a tuple of dataclasses is filled from."""
        ...


class MappingSource:
    """A mapping that something else has read, such as `json.loads`.

    Args:
        document: the mapping.
        name: begins every complaint; without a name they begin with the path of the field.
        error: what they are.
    """

    def __init__(
        self,
        document: Mapping[str, object],
        name: str = "",
        error: type[ReflexarcError] = UsageError,
    ) -> None:
        self.document = document
        self._name, self._error = name, error

    def complaint(self, path: KeyPath, words: str) -> ReflexarcError:
        """The error for what stands at a path."""
        where = f"{self._name}.{dotted(path)}".strip(".")
        return self._error(f"{where}: {words}" if where else words)

    def one_table(self, path: KeyPath) -> str:
        """What a dataclass is filled from."""
        return "an object"

    def many_tables(self, path: KeyPath) -> str:
        """What a tuple of dataclasses is filled from."""
        return "a list of objects"
