"""Meshes, clouds and holes: made, read, written, counted."""
import unittest

import numpy
import orbweave
from support import program, sphere

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


class Meshes(unittest.TestCase):
    def test_a_mesh_of_arrays_is_counted_as_the_program_counts_it(self):
        mesh = orbweave.Mesh(*TETRAHEDRON)
        facts = orbweave.inspect(mesh)
        self.assertEqual((facts["vertices"], facts["triangles"], facts["euler_characteristic"]), (4, 4, 2))
        self.assertTrue(facts["watertight"])
        for name in ("t.ply", "t.obj", "t.stl", "t.ply.gz"):
            orbweave.write_mesh(name, mesh)
            self.assertEqual(len(orbweave.read_mesh(name).triangles), 4)
        self.assertIn('"watertight": true', program("inspect", "t.ply", "--json").stdout)

    def test_an_origin_is_read_as_it_was_written(self):
        mesh = orbweave.Mesh(numpy.array(TETRAHEDRON[0]) + [500000.0, 5000000.0, 0.0], TETRAHEDRON[1])
        cloud = orbweave.PointCloud(mesh.vertices)
        for name in ("o.ply", "o.obj", "o.xyz"):
            for origin in ((500000, 5000000, 0), (0, 0, 0)):
                if name == "o.xyz":
                    orbweave.write_points(name, cloud, origin=origin)
                    read = orbweave.read_points(name).points
                else:
                    orbweave.write_mesh(name, mesh, origin=origin)
                    read = orbweave.read_mesh(name).vertices
                self.assertTrue(numpy.array_equal(read, mesh.vertices), (name, origin))

    def test_numbers_of_holes_are_integers_of_32_bits(self):
        for wrong in ([1.7] * 4, [2**40] * 4, [1, 2], ["a"] * 4, object()):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.Mesh(*TETRAHEDRON, triangle_hole=wrong)
            self.assertEqual(caught.exception.place, "triangle_hole")
        mesh = orbweave.Mesh(*TETRAHEDRON, triangle_hole=numpy.arange(4, dtype=">i8"))
        self.assertEqual(mesh.triangle_hole.tolist(), [0, 1, 2, 3])
        self.assertEqual(len(orbweave.Mesh(TETRAHEDRON[0], [], triangle_hole=[]).triangles), 0)

    def test_only_meshes_are_written_as_meshes(self):
        for call, wrong in ((orbweave.write_mesh, orbweave.PointCloud(sphere(10))), (orbweave.write_points, sphere(10))):
            with self.assertRaisesRegex(TypeError, f"not {type(wrong).__name__}"):
                call("wrong.ply", wrong)
        with self.assertRaisesRegex(TypeError, "orbweave.Mesh"):
            orbweave.inspect(sphere(10))

    def test_a_triangle_of_a_vertex_that_is_not_there_is_refused(self):
        for wrong in ([[0, 1, 4]], [[0, 1, -1]]):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.Mesh(TETRAHEDRON[0], wrong)
            self.assertEqual(caught.exception.expected, "a number below 4")

    def test_holes_say_what_became_of_them(self):
        points = sphere(2000)
        mesh = orbweave.reconstruct(points[points[:, 2] < 0.9], points[points[:, 2] < 0.9], max_edges=1000)
        self.assertEqual(len(mesh.holes), 1)
        hole = mesh.holes[0]
        self.assertTrue(hole.filled)
        self.assertEqual(hole.triangles_added, int(numpy.count_nonzero(mesh.triangle_hole == hole.id)))
        self.assertAlmostEqual(hole.center[2], 0.9, delta=0.05)
        self.assertTrue(0.0 < hole.confidence <= 1.0)
        self.assertIn("filled", repr(hole))
        self.assertEqual(sorted(mesh.ball_radii), mesh.ball_radii)

    def test_without_the_fill_no_hole_is_listed(self):
        points = sphere(2000)
        mesh = orbweave.reconstruct(points[points[:, 2] < 0.9], fill=False)
        self.assertEqual(mesh.holes, [])

    def test_points_that_were_left_out_are_counted(self):
        mesh = orbweave.reconstruct(numpy.vstack([sphere(800), [[numpy.nan, 0, 0]], sphere(800)[:5]]))
        self.assertEqual(sum(mesh.dropped.values()), 6)


class Clouds(unittest.TestCase):
    def test_a_cloud_is_read_as_it_was_written(self):
        points = sphere(500)
        orbweave.write_points("c.ply", orbweave.PointCloud(points, points, attributes={"red": numpy.full(500, 7, numpy.uint8)}))
        cloud = orbweave.read_points("c.ply")
        self.assertEqual(len(cloud), 500)
        self.assertTrue(numpy.array_equal(cloud.points, points))
        self.assertTrue(numpy.array_equal(cloud.normals, points))
        self.assertTrue((cloud.attributes["red"] == 7).all())
        self.assertEqual(cloud.coordinate_system, "")

    def test_a_cloud_brings_its_normals_itself(self):
        with self.assertRaises(orbweave.UsageError):
            orbweave.reconstruct(orbweave.PointCloud(sphere(500)), sphere(500))


if __name__ == "__main__":
    unittest.main(verbosity=2)
