"""One half of the world's step is compiled by a second process while this one compiles the other.

That is done once for each state of the sources, and is much of the first start's time. The two
processes hand types over as pickles, through a pipe that nobody else writes to.
"""

import pickle
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from reflexarc_sim_bridge.native.helper_process import at_work, end_with_parent
from reflexarc_sim_bridge.native.lean import uncollected


@contextmanager
def compiled_meanwhile(function: Any, types: tuple[Any, ...]) -> Iterator[None]:
    """Within it another process compiles a function; afterwards it is in the cache.

    Args:
        function: a compiled one, at the top level of its module.
        types: numba's, of its arguments.
    """
    with at_work(__name__, pickle.dumps((function.__module__, function.__name__, types))):
        yield


def main() -> None:
    """The other process: module, function and types come in on standard input, as a pickle."""
    try:
        module, name, types = pickle.load(sys.stdin.buffer)
        function = getattr(import_module(module), name)
    except Exception as error:  # a pickle of garbage can raise anything
        print(
            f"compile_meanwhile: expected a pickled call on standard input: {error}",
            file=sys.stderr,
        )
        raise SystemExit(2) from None
    end_with_parent()
    with uncollected():
        function.compile(types)


if __name__ == "__main__":
    main()
