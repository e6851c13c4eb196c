"""Nothing that a stranger can reach is unpickled: a pickle runs code as its reader."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("baselines", "cli", "logs", "pictures", "runtime", "sim_bridge", "trainer")

REFUSED = {
    "pickle",
    "_pickle",
    "cloudpickle",
    "dill",
    "joblib",
    "jsonpickle",
    "marshal",
    "multiprocessing",
    "shelve",
    "yaml",
}
"""Modules that load code with data; multiprocessing's queues and pipes are pickles too."""
ALLOWED = {("sim_bridge/reflexarc_sim_bridge/native/helper_process.py", "pickle")}
"""Types of the compiler, through the standard input of a process of one's own."""
SAFELY = {"allow_pickle": False, "weights_only": True}
"""What `np.load` and `torch.load` must be told, and not left to a default."""
MODULES_WITH_LOADERS = {"np", "numpy", "torch"}


def sources() -> Iterator[Path]:
    for room in ROOMS:
        yield from (ROOT / room).rglob("*.py")


def offences(text: str, name: str) -> list[str]:
    return [found for node in ast.walk(ast.parse(text)) for found in _of(node, name)]


def _of(node: ast.AST, name: str) -> Iterator[str]:
    modules: list[str] = []
    if isinstance(node, ast.Import):
        modules = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        modules = [node.module or "", *(f"{node.module}.{a.name}" for a in node.names)]
    for module in modules:
        top = module.partition(".")[0]
        if top in REFUSED and (name, top) not in ALLOWED:
            yield f"{name}: imports {module}"
        if module.endswith("ProcessPoolExecutor"):
            yield f"{name}: {module} talks in pickles"
    if isinstance(node, ast.Call) and _loads(node.func):
        said = {k.arg: k.value.value for k in node.keywords if isinstance(k.value, ast.Constant)}
        if not any(said.get(k) is v for k, v in SAFELY.items()):
            yield f"{name}: line {node.lineno}: expected allow_pickle=False or weights_only=True"
    if isinstance(node, ast.keyword) and node.arg == "allow_pickle":
        is_refused = isinstance(node.value, ast.Constant) and node.value.value is False
        if not is_refused:
            yield f"{name}: allow_pickle"


def _loads(function: ast.expr) -> bool:
    return (
        isinstance(function, ast.Attribute)
        and function.attr == "load"
        and isinstance(function.value, ast.Name)
        and function.value.id in MODULES_WITH_LOADERS
    )


def test_no_module_unpickles_what_a_stranger_can_reach():
    found = [
        offence
        for path in sources()
        for offence in offences(path.read_text(), str(path.relative_to(ROOT)))
    ]
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from pickle import loads",
        "import multiprocessing.connection",
        "from concurrent.futures import ProcessPoolExecutor",
        "import numpy as np\nnp.load(path)",
        "np.load(path, allow_pickle=True)",
        "torch.load(path)",
        "torch.load(path, weights_only=False)",
        "np.savez(path, allow_pickle=flag)",
    ],
)
def test_each_kind_of_it_is_noticed(text: str):
    assert offences(text, "somewhere.py") != []


def test_what_is_allowed_is_still_there_and_nowhere_else():
    for name, module in ALLOWED:
        text = (ROOT / name).read_text()
        assert offences(text, name) == []
        assert offences(text, "elsewhere.py") == [f"elsewhere.py: imports {module}"]
