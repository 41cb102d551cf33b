"""The wheel is made offline, from packages of the system alone, and the module in it works."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import zipfile

SOURCE, BINARY = pathlib.Path(os.environ["ORBWEAVE_SOURCE_DIR"]), os.environ["ORBWEAVE_BINARY_DIR"]


def main():
    for module in ("pip", "setuptools", "wheel"):
        if importlib.util.find_spec(module) is None:
            print(f"SKIPPED: the Python module {module} is missing")
            return
    # A copy, because setuptools writes beside its sources.
    shutil.copytree(SOURCE / "python", "tree/python")
    shutil.copy(SOURCE / "CMakeLists.txt", "tree")
    # Relative to the root of the sources, as docs/python.md names it; pip's own folder is another one.
    build = os.path.relpath(BINARY, "tree")
    subprocess.run([sys.executable, "-m", "pip", "wheel", "--no-index", "--no-build-isolation", "--no-deps",
                    "--disable-pip-version-check", "-w", "wheels", "./tree/python"], check=True,
                   env=dict(os.environ, ORBWEAVE_BUILD_DIR=build))
    wheels = list(pathlib.Path("wheels").glob("orbweave-*.whl"))
    assert len(wheels) == 1, wheels
    with zipfile.ZipFile(wheels[0]) as wheel:
        names = set(wheel.namelist())
        assert {"orbweave/__init__.py", "orbweave/__init__.pyi", "orbweave/py.typed"} <= names, names
        wheel.extractall("installed")
    done = subprocess.run([sys.executable, "-c", "import orbweave; print(orbweave.__file__, orbweave.__version__)"],
                          env=dict(os.environ, PYTHONPATH="installed"), capture_output=True, text=True, check=True)
    assert "installed" in done.stdout, done.stdout
    print(wheels[0].name, "works")


if __name__ == "__main__":
    main()
