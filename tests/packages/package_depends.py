#!/usr/bin/env python3
"""Every package that find_package(orbweave) looks for comes with liborbweave-dev, and docs/library.md names it. usage:
package_depends.py SOURCE_DIR"""
import pathlib
import re
import sys

SOURCE = pathlib.Path(sys.argv[1])
# What orbweaveConfig.cmake asks for: its Debian package, and its name in the documents. Threads are part of the C library;
# CGAL belongs to builds that are packed without the libraries.
PACKAGES = {"Threads": None, "CGAL": None, "TBB": ("libtbb-dev", "TBB"), "ZLIB": ("zlib1g-dev", "zlib"), "PNG": ("libpng-dev", "PNG"),
            "spdlog": ("libspdlog-dev", "spdlog"), "XxHash": ("libxxhash-dev", "xxHash"), "ProjCore": ("libproj-dev", "PROJ"),
            "Hdf5Core": ("libhdf5-dev", "HDF5"), "OpenVdbCore": ("libopenvdb-dev", "OpenVDB"),
            "meshoptimizer": ("libmeshoptimizer-dev", "meshoptimizer"), "pugixml": ("libpugixml-dev", "pugixml")}


def text_of(path):
    return (SOURCE / path).read_text(encoding="utf-8")


wanted = set(re.findall(r"find_dependency\((\w+)", text_of("cmake/orbweaveConfig.cmake.in")))
depends = re.search(r'CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "([^"]*)"', text_of("cmake/OrbweavePackages.cmake")).group(1).split(", ")
documented = re.search(r"^\| `pipeline` \|.*\| (.*) \|$", text_of("docs/library.md"), re.M).group(1).split(", ")
complaints = [f"{name} is not known here" for name in sorted(wanted - set(PACKAGES))]
for name in sorted(wanted & set(PACKAGES)):
    if PACKAGES[name] is None:
        continue
    package, title = PACKAGES[name]
    if package not in depends:
        complaints.append(f"liborbweave-dev does not depend on {package}")
    if title not in documented:
        complaints.append(f"docs/library.md does not name {title}")
if complaints or len(wanted) < 10:
    sys.exit("package_depends: " + "; ".join(complaints or ["no packages"]))
print(f"package_depends: {len(wanted)} packages are in order")
