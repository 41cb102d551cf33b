"""Runs a script with the module of this build, in a scratch directory; says which one is missing where one is.
usage: with_module.py MODULE_DIR SCRIPT"""
import os
import pathlib
import runpy
import sys
import tempfile


def main():
    module_dir, script = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    if not any((module_dir / "orbweave").glob("_orbweave*.so")):
        print("SKIPPED: the Python module is not built (pybind11 or Python's headers are missing)")
        return
    try:
        import numpy  # noqa: F401
    except ImportError:
        print("SKIPPED: the Python module numpy is missing")
        return
    sys.path.insert(0, str(module_dir))
    os.environ["PYTHONPATH"] = str(module_dir)
    sys.argv = [str(script)]
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)
        sys.path.insert(1, str(script.parent))
        try:
            runpy.run_path(str(script), run_name="__main__")
        finally:
            os.chdir("/")


if __name__ == "__main__":
    main()
