"""Importing does nothing: no module writes, loads the bus, or changes somebody else's classes."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import pytest

PACKAGES = ("runtime", "logs", "sim_bridge", "trainer", "pictures")

NOWHERE = "/proc/self/none"
"""A place where nobody can make a folder, not even root."""

IMPORT_ALL = """
import importlib, json, os, pkgutil, sys

PACKAGES = sys.argv[1].split(",")
FLAGS = os.O_WRONLY | os.O_RDWR | os.O_CREAT
CHANGES = {"os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.utime"}
writes, errors, bus = [], {}, []


def writing(event, arguments):
    if event == "open":
        mode, flags = arguments[1:]
        return bool(set(mode or "") & set("wax+")) or bool((flags or 0) & FLAGS)
    return event in CHANGES


def watch(event, arguments):
    if not writing(event, arguments):
        return
    frame = sys._getframe(1)
    while frame and frame.f_code.co_name != "<module>":
        frame = frame.f_back
    # The innermost module whose own lines run: what others write when they are imported is theirs.
    module = frame.f_globals["__name__"] if frame else ""
    if module.partition(".")[0] in PACKAGES:
        writes.append({"module": module, "what": str(arguments[0])})


sys.addaudithook(watch)
for name in PACKAGES:
    package = importlib.import_module(name)
    for found in pkgutil.walk_packages(package.__path__, name + "."):
        if found.name.endswith("__main__"):
            continue
        try:
            importlib.import_module(found.name)
        except ModuleNotFoundError as error:
            if error.name != "rerun":  # of the extra `view`, which is not among the developers'
                errors[found.name] = repr(error)
        except Exception as error:
            errors[found.name] = repr(error)
print(json.dumps({"writes": writes, "errors": errors}))
"""


def without_home() -> dict[str, str]:
    """An environment in which no folder of the user can be written."""
    nowhere = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"), NOWHERE)
    without = {"NUMBA_CACHE_DIR", "MPLCONFIGDIR"}
    return {k: v for k, v in os.environ.items() if k not in without} | nowhere


@pytest.fixture(scope="module")
def imported() -> Mapping[str, Any]:
    """What happened while every module was imported, without a home to write to."""
    packages = ",".join(("reflexarc", *(f"reflexarc_{room}" for room in PACKAGES)))
    command = [sys.executable, "-B", "-c", IMPORT_ALL, packages]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=without_home())
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def test_every_module_can_be_imported_without_a_home(imported: Mapping[str, Any]) -> None:
    assert imported["errors"] == {}


def test_importing_writes_no_file_and_makes_no_folder(imported: Mapping[str, Any]) -> None:
    assert imported["writes"] == []


def test_without_a_home_compiled_code_runs_and_one_line_says_why_it_is_not_kept() -> None:
    code = """
from reflexarc_sim_bridge.native.intrinsics import whole
from reflexarc_sim_bridge.native.cache import prepare
prepare()
prepare()
print(whole(17))
"""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, env=without_home(), check=True)
    assert done.stdout == "32\n"
    [line] = done.stderr.splitlines()
    assert "cannot keep compiled code" in line
    assert "NUMBA_CACHE_DIR names another folder" in line


def test_importing_the_front_door_loads_no_room() -> None:
    command = [sys.executable, "-X", "importtime", "-c", "import reflexarc"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "reflexarc" in loaded
    assert not {name for name in loaded if name.startswith("reflexarc_")}
    assert not loaded & {"numpy", "gymnasium", "numba", "torch", "zenoh"}


def test_only_the_bus_loads_zenoh() -> None:
    code = """
import importlib, pkgutil, sys
for name in sys.argv[1:]:
    package = importlib.import_module(name)
    for found in pkgutil.walk_packages(package.__path__, name + "."):
        apart = ("reflexarc_runtime.bus", "__main__", "rerun_canvas")
        if not found.name.endswith(apart):
            importlib.import_module(found.name)
            assert "zenoh" not in sys.modules, found.name
"""
    rooms = ("reflexarc", *(f"reflexarc_{room}" for room in PACKAGES))
    done = subprocess.run([sys.executable, "-c", code, *rooms], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_name_of_a_robot_is_checked_without_zenoh() -> None:
    code = """
import sys
from reflexarc.main import main
print(main(["import", "carmen", "none.log", "--out", "none.mcap", "--robot", "a/b"]))
print("zenoh" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "--robot: expected letters, digits" in done.stderr
    assert done.stdout.split() == ["2", "False"]
