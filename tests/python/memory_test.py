"""Reconstructing an array copies the points once: the peak of the process grows by some 220 bytes per point beside the
arrays of the caller, and one more copy of points and normals would show."""
import os
import subprocess
import sys
import unittest

CODE = """
import resource, sys
sys.path.insert(0, sys.argv[2])
import orbweave
from support import sphere
points = sphere(int(sys.argv[1]))
normals = points.copy()
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
mesh = orbweave.reconstruct(points, normals, threads=2)
views = mesh.vertices, mesh.triangles, mesh.normals
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
BYTES_PER_POINT = 250


def grown_bytes(points):
    here = os.path.dirname(os.path.abspath(__file__))
    done = subprocess.run([sys.executable, "-c", CODE, str(points), here], capture_output=True, text=True, check=True)
    return 1024 * int(done.stdout)


class Memory(unittest.TestCase):
    def test_peak_per_point(self):
        small, large = grown_bytes(200_000), grown_bytes(400_000)
        print(f"{small / 200_000:.0f} and {large / 400_000:.0f} bytes per point, {(large - small) / 200_000:.0f} for each more")
        self.assertLess((large - small) / 200_000, BYTES_PER_POINT)
        self.assertLess(large, 400_000 * BYTES_PER_POINT + (16 << 20))


if __name__ == "__main__":
    unittest.main(verbosity=2)
