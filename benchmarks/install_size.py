"""How large is an installation of a target, dependency by dependency?

    python benchmarks/install_size.py [--extra sim] [--json]

By what each distribution says it installed (its RECORD), compiled Python files left out. A
distribution counts once, however many want it; those that only an extra brings are left out.
"""

import argparse
import json
import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--extra", default="", help="of reflexarc")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    found = _needed("reflexarc", arguments.extra)
    mb = {name: _megabytes(each) for name, each in found.items() if name != "reflexarc"}
    if arguments.json:
        print(json.dumps(mb))
        return
    print("| distribution | version | MB |\n|---|---|---|")
    for name, size in sorted(mb.items(), key=lambda pair: -pair[1]):
        print(f"| {name} | {found[name].version} | {size:.1f} |")
    print(f"| all | | {sum(mb.values()):.1f} |")


def _needed(root: str, extra: str) -> dict[str, Distribution]:
    """A distribution and all that it needs here, by name."""
    found: dict[str, Distribution] = {}
    waiting = [(root, extra)]
    while waiting:
        name, its_extra = waiting.pop()
        name = re.sub(r"[-_.]+", "-", name).lower()
        if name in found:
            continue
        try:
            found[name] = distribution(name)
        except PackageNotFoundError:
            continue
        for words in found[name].requires or []:
            each = Requirement(words)
            if each.marker is None or each.marker.evaluate({"extra": its_extra}):
                waiting.append((each.name, ""))
    return found


def _megabytes(found: Distribution) -> float:
    files = [file for file in found.files or [] if file.suffix != ".pyc"]
    paths = [Path(str(file.locate())) for file in files]
    return sum(path.stat().st_size for path in paths if path.exists()) / 1e6


if __name__ == "__main__":
    main()
