"""Studies by name: the shipped ones by theirs, others by the path of their file."""

from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.definition import Study, read_study

SUFFIX = ".toml"

_FOLDER = Path(__file__).parent / "shipped"


def study_names() -> tuple[str, ...]:
    """Names of the shipped studies, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob(f"*{SUFFIX}")))


def study_named(name: str) -> Study:
    """The shipped study of a name, or the study of a file's path.

    Raises:
        ReflexarcError: there is no such study, or it cannot be run.
    """
    if name in study_names():
        return read_study(_FOLDER / f"{name}{SUFFIX}")
    if "/" in name or name.endswith(SUFFIX):
        return read_study(Path(name))
    known = ", ".join(study_names())
    raise UsageError(f"study: none is named {name!r}; known: {known}; or give a file, *{SUFFIX}")
