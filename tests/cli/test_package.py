import ast
import subprocess
import sys

import pytest

import reflexarc

PUBLIC = [
    "Policy",
    "PolicyContract",
    "ReferenceEnv",
    "ReferenceVectorEnv",
    "ReflexarcError",
    "RetinaSpec",
    "evaluate",
    "export",
    "export_sb3",
    "load_policy",
    "measure",
    "preset_named",
    "read_log",
    "replay",
    "train",
    "world_named",
]


def test_the_public_names_are_these_and_each_can_be_loaded():
    assert reflexarc.__all__ == PUBLIC
    assert dir(reflexarc) == sorted(PUBLIC)
    assert all(getattr(reflexarc, name).__name__ == name for name in PUBLIC)
    assert reflexarc.__version__ == "0.1.0"
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        reflexarc.fly  # noqa: B018


def test_importing_the_facade_loads_no_room():
    code = "import reflexarc, sys; print([m for m in sys.modules if m.startswith('reflexarc_')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ast.literal_eval(done.stdout) == []
