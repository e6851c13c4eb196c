"""What a person types when a file is broken."""

from pathlib import Path

from reflexarc_runtime.words.suggestion import pasteable


def recovery(path: Path | str) -> str:
    """The command that saves what is left of a file, to be pasted as it stands."""
    return f"`{pasteable('reflexarc', 'recover', Path(path), '-o', 'FIXED.mcap')}`"
