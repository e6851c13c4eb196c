"""Bytecode that is kept, as an installation keeps it, whatever the environment says."""

import os
from pathlib import Path


def keep_bytecode(folder: Path) -> None:
    """Let every process that this one starts keep its bytecode in a folder.

    pip compiles what it installs. Where PYTHONDONTWRITEBYTECODE is set a checkout is compiled at
    every start, which takes a third of it: no robot starts like that.
    """
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = str(folder)
