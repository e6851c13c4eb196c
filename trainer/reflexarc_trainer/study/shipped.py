"""The studies of this package, by their names; and any other by its file."""

from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.definition import Study, read_study

SUFFIX = ".toml"

_FOLDER = Path(__file__).parent / "shipped"


def study_names() -> tuple[str, ...]:
    """Names of the studies of this package."""
    return tuple(sorted(path.stem for path in _FOLDER.glob(f"*{SUFFIX}")))


def study_named(name: str) -> Study:
    """The study of that name, or of that file.

    Raises:
        ReflexarcError: there is none, or it is none that can be run.
    """
    if name in study_names():
        return read_study(_FOLDER / f"{name}{SUFFIX}")
    if "/" in name or name.endswith(SUFFIX):
        return read_study(Path(name))
    known = ", ".join(study_names())
    raise UsageError(f"study: none is named {name!r}; known: {known}; or give a file, *{SUFFIX}")
