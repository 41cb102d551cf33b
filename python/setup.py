"""Builds the wheel: CMake compiles the module, setuptools packs it. docs/python.md

ORBWEAVE_BUILD_DIR names a build directory to use, with what it holds already; otherwise one is made. A relative
path begins at the root of the sources: pip runs this file in its own folder, wherever it was called."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parent


class BuildByCMake(build_ext):
    """Configures with the Python that packs, builds one target, takes its module."""

    def build_extension(self, ext):
        named = os.environ.get("ORBWEAVE_BUILD_DIR")
        build = SOURCE / named if named else pathlib.Path(self.build_temp).resolve() / "cmake"
        if not (build / "CMakeCache.txt").exists():
            subprocess.run(["cmake", "-S", SOURCE, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DORBWEAVE_PYTHON=ON",
                            f"-DPython_EXECUTABLE={sys.executable}", "-DORBWEAVE_BUILD_TESTS=OFF",
                            "-DORBWEAVE_BUILD_BENCH=OFF", "-DORBWEAVE_MPI=OFF", "-DORBWEAVE_VORONOI=OFF"], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "orbweave_python", "--parallel"], check=True)
        name = pathlib.Path(self.get_ext_fullpath(ext.name))
        made = build / "python" / "orbweave" / name.name
        if not made.exists():
            sys.exit(f"{build} was configured for another Python: there is no {made.name}")
        name.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(made, name)


def version():
    text = (SOURCE / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"^project\(orbweave VERSION (\S+)", text, re.M).group(1)


setup(
    name="orbweave",
    version=version(),
    description="Parallel, out-of-core surface reconstruction of point clouds",
    license="MPL-2.0",
    packages=["orbweave"],
    package_data={"orbweave": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("orbweave._orbweave", sources=[])],
    cmdclass={"build_ext": BuildByCMake},
    python_requires=">=3.9",
    install_requires=["numpy"],
    zip_safe=False,
)
