"""What evolution found, as small TOML files that ship with the package.

[genome]          # the fields of the system's own dataclass
weights = [...]

[provenance]      # `Ancestry`: how it came about
command = "python -m reflexarc_baselines.evolving closed-loop --seed 0"
"""

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import UsageError

_FOLDER = Path(__file__).parent / "shipped"

_Genome = TypeVar("_Genome")


@dataclass(frozen=True)
class Ancestry:
    """How a genome came about."""

    command: str
    """That finds this genome again."""
    seed: int
    generations: int
    genomes: int
    """In each generation."""
    worlds: int
    """In which each genome of a generation was tried, new ones every time."""
    steps: int
    """In each world."""
    first_generation: float
    """Contacts per 100 m of the first generation's best, on the fixed validation worlds."""
    stopped_at: float
    """Those of the best at the end, on the same worlds."""
    validation: float
    """Those of this genome on the validation worlds of the last choice, which chose nothing else;
    it is the best of a few there, so a little lucky."""
    why_it_ended: str


def shipped(name: str, kind: type[_Genome]) -> _Genome:
    """The genome that a system ships with."""
    return read_genome(_FOLDER / f"{name}.toml", kind)


def provenance_of(path: Path) -> Ancestry:
    """How the genome of a file came about."""
    return fill(Ancestry, _part(path, "provenance"), require_all=True)


def read_genome(path: Path, kind: type[_Genome]) -> _Genome:
    """The genome of a file.

    Raises:
        UsageError: no such file, no TOML, or fields that are missing, unknown or of a wrong type.
    """
    return fill(kind, _part(path, "genome"), require_all=True)


def shipped_path(name: str) -> Path:
    """Where the genome of a system stands."""
    return _FOLDER / f"{name}.toml"


def genome_text(genome: object, provenance: Ancestry) -> str:
    """A genome and how it came about, as `read_genome` and `provenance_of` read them."""
    return f"[genome]\n{_table(genome)}\n[provenance]\n{_table(provenance)}"


def _part(path: Path, name: str) -> MappingSource:
    document = TomlSource(read_text(path, str(path)), str(path)).document
    if not isinstance(document.get(name), dict):
        raise UsageError(f"{path}: expected a table [{name}], got none")
    return MappingSource(document[name], f"{path}: {name}", UsageError)


def _table(of: object) -> str:
    assert dataclasses.is_dataclass(of)
    return "".join(f"{f.name} = {_value(getattr(of, f.name))}\n" for f in dataclasses.fields(of))


def _value(value: object) -> str:
    if isinstance(value, tuple):
        lines = "".join(f"    {_value(each)},\n" for each in value)
        return f"[\n{lines}]" if any(isinstance(v, str) for v in value) else _in_one_line(value)
    return f'"{value}"' if isinstance(value, str) else repr(value)


def _in_one_line(values: tuple[object, ...]) -> str:
    return f"[{', '.join(map(repr, values))}]"
