"""A mesh from Python has the bytes of the file that the program writes of the same points."""
import unittest

import numpy
import orbweave
from support import bytes_of, program, sphere


class SameBytesAsTheProgram(unittest.TestCase):
    def check(self, cloud_file, mesh, *options):
        program("reconstruct", cloud_file, "-o", "program.ply", "--progress", "none", *options)
        orbweave.write_mesh("module.ply", mesh)
        self.assertEqual(bytes_of("module.ply"), bytes_of("program.ply"))

    def test_points_without_normals(self):
        points = sphere()
        orbweave.write_points("cloud.ply", orbweave.PointCloud(points))
        self.check("cloud.ply", orbweave.reconstruct(points))

    def test_points_with_normals(self):
        points = sphere(1500)[:1200]
        orbweave.write_points("cloud.ply", orbweave.PointCloud(points, points))
        self.check("cloud.ply", orbweave.reconstruct(points, points, ball_radii=[0.1, 0.2]), "--ball-radii", "0.1,0.2")

    def test_normals_of_float32_stay_such(self):
        points = sphere(1000)
        normals = points.astype(numpy.float32)
        orbweave.write_points("cloud.ply", orbweave.PointCloud(points, normals))
        self.check("cloud.ply", orbweave.reconstruct(points, normals))

    def test_attributes_reach_the_vertices(self):
        points = sphere(1000)
        attributes = {"red": (255 * (points[:, 0] > 0)).astype(numpy.uint8), "height": points[:, 2].astype(numpy.float32)}
        orbweave.write_points("cloud.ply", orbweave.PointCloud(points, points, attributes=attributes))
        mesh = orbweave.reconstruct(points, points, attributes=attributes)
        self.check("cloud.ply", mesh)
        self.assertTrue(numpy.array_equal(mesh.attributes["red"][:1000] > 0, mesh.vertices[:1000, 0] > 0))

    def test_a_cloud_from_a_file(self):
        program("generate", "bumpy-torus", "--points", "3000", "-o", "scan.ply")
        self.check("scan.ply", orbweave.reconstruct(orbweave.read_points("scan.ply")))

    def test_any_number_of_threads_and_any_order(self):
        points = sphere(1500)
        orbweave.write_mesh("one.ply", orbweave.reconstruct(points, threads=1))
        orbweave.write_mesh("two.ply", orbweave.reconstruct(points[::-1], threads=2))
        self.assertEqual(bytes_of("one.ply"), bytes_of("two.ply"))

    def test_a_mesh_that_was_read_is_written_as_it_was(self):
        orbweave.write_mesh("first.ply", orbweave.reconstruct(sphere()))
        orbweave.write_mesh("second.ply", orbweave.read_mesh("first.ply"))
        self.assertEqual(bytes_of("first.ply"), bytes_of("second.ply"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
