"""Finds a Python that has the packages that a script needs, and the modules of bench/.

A script of the benchmarks begins with need("numpy", ...), before it imports anything that is not in the
standard library. Where this interpreter lacks a package, the script starts over in one that has them all:
ORBWEAVE_PYTHON, the python3 of the PATH, or the system's, which has Debian's packages.
"""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

BENCH = pathlib.Path(__file__).resolve().parent
DEBIAN_NAMES = {"numpy": "python3-numpy", "scipy": "python3-scipy", "matplotlib": "python3-matplotlib", "PIL": "python3-pil",
                "open3d": "python3-open3d"}
STARTED_OVER = "ORBWEAVE_PYTHON_STARTED_OVER"

for folder in ("peers", "models", "quality", "workloads", "."):
    sys.path.insert(1, str((BENCH / folder).resolve()))


def candidates():
    """Interpreters to try, this one first."""
    names = [sys.executable, os.environ.get("ORBWEAVE_PYTHON"), shutil.which("python3"), "/usr/bin/python3"]
    return list(dict.fromkeys(name for name in names if name and os.access(name, os.X_OK)))


def has(python, packages):
    words = [python, "-c", "import importlib.util, sys\n"
             "sys.exit(any(importlib.util.find_spec(name) is None for name in sys.argv[1:]))", *packages]
    return subprocess.run(words, capture_output=True, check=False).returncode == 0


def with_packages(*packages):
    """Path of an interpreter that has all of them; None where there is none."""
    return next((python for python in candidates() if has(python, packages)), None)


def need(*packages):
    """Returns where this interpreter has all of them; else starts the script over in one that has, or ends it."""
    missing = [name for name in packages if importlib.util.find_spec(name) is None]
    if not missing:
        return
    python = None if os.environ.get(STARTED_OVER) else with_packages(*packages)
    if python is None:
        names = " ".join(DEBIAN_NAMES.get(name, name) for name in missing)
        sys.exit(f"{sys.argv[0]}: no Python here has {', '.join(missing)}. Install {names}, "
                 "or name an interpreter in ORBWEAVE_PYTHON.")
    os.environ[STARTED_OVER] = "1"
    os.execv(python, [python, *sys.argv])
