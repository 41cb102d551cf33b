"""Arrays go in as they are and come out as views; wrong ones are refused with what is expected."""
import gc
import pathlib
import types
import unittest

import numpy
import orbweave
from support import bytes_of, sphere


class Wrapping:
    """An array as other packages wrap it."""

    def __init__(self, array):
        self.array = array

    def __array__(self, *_, **__):
        return self.array


class Unready:
    """Neither an array nor a mapping yet: Python raises what it is told to."""

    def __init__(self, raised):
        self.raised = raised

    def __array__(self, *_, **__):
        raise self.raised

    def keys(self):
        raise self.raised

    def __iter__(self):
        raise self.raised


class ArraysIn(unittest.TestCase):
    def same(self, points, normals=None):
        expected = orbweave.reconstruct(numpy.ascontiguousarray(points, dtype=numpy.float64))
        mesh = orbweave.reconstruct(points, normals)
        self.assertTrue(numpy.array_equal(mesh.triangles, expected.triangles))

    def test_any_layout_of_the_same_numbers(self):
        points = sphere(800)
        self.same(numpy.asfortranarray(points))
        self.same(numpy.repeat(points, 2, axis=0)[::2])
        self.same(points.tolist())
        self.same(points.astype(">f8"))

    def test_float32_is_taken_as_the_doubles_that_it_is(self):
        narrow = sphere(800).astype(numpy.float32)
        self.same(narrow)

    def test_the_array_of_the_caller_stays_as_it_is(self):
        points = sphere(800)
        before = points.copy()
        orbweave.reconstruct(points)
        self.assertTrue(numpy.array_equal(points, before))

    def test_normals_face_the_scanner_of_each_point(self):
        x, y = numpy.meshgrid(numpy.arange(40) * 0.1, numpy.arange(40) * 0.1)
        points = numpy.stack([x.ravel(), y.ravel() + 0.002 * numpy.sin(7 * x.ravel()), 0 * x.ravel()], axis=1)

        def share_down(scanners, given=points, **options):
            mesh = orbweave.reconstruct(given, scanners=scanners, **options)
            corners = mesh.vertices[mesh.triangles]
            return (numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < 0).mean()

        self.assertEqual(share_down(None), 0)
        for scanners in (points - [0, 0, 3], [[2, 2, -9]], (points - [0, 0, 3]).tolist()):
            self.assertEqual(share_down(scanners), 1)
        self.assertEqual(share_down([[2, 2, -9]], orbweave.PointCloud(points), orientation="scanner"), 1)
        self.assertEqual(share_down([[2, 2, -9]], attributes={"scan": numpy.ones(len(points))}), 1)
        for wrong, place in ((points[:7], "scanners"), (numpy.zeros((0, 3)), "scanners"), ([1, 2, 3], "scanners")):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(points, scanners=wrong)
            self.assertEqual(caught.exception.place, place)

    def test_wrong_shapes_and_types_are_refused(self):
        for wrong in (numpy.zeros((5, 2)), numpy.zeros(6), numpy.zeros((2, 3), dtype=complex), [["a", "b", "c"]], "points", None):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(wrong)
            self.assertEqual(caught.exception.place, "points")
            self.assertTrue(caught.exception.expected)

    def test_normals_of_float32_stay_such_in_any_wrapping(self):
        points = sphere(800)
        narrow = points.astype(numpy.float32)
        orbweave.write_mesh("expected.ply", orbweave.reconstruct(orbweave.PointCloud(points, narrow)))
        for normals in (narrow, narrow.astype(">f4"), memoryview(narrow), Wrapping(narrow)):
            orbweave.write_mesh("mesh.ply", orbweave.reconstruct(points, normals))
            self.assertEqual(bytes_of("mesh.ply"), bytes_of("expected.ply"))

    def test_what_python_raises_at_an_array_is_told(self):
        for raised, told in ((TypeError("move the tensor to the host first"), "TypeError: move the tensor to the host first"),
                             (ValueError(), "ValueError: ")):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(Unready(raised))
            self.assertEqual((caught.exception.place, caught.exception.found), ("points", told))
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.PointCloud([[0, 0, 0], [1, 1]])
        self.assertIn("ValueError", caught.exception.found)

    def test_ctrl_c_and_a_lack_of_memory_are_no_objection_to_a_value(self):
        points = sphere(10)
        mesh = orbweave.Mesh(points, [[0, 1, 2]])
        for raised in (KeyboardInterrupt, MemoryError):
            unready = Unready(raised())
            for call in (lambda: orbweave.reconstruct(unready), lambda: orbweave.reconstruct(points, unready),
                         lambda: orbweave.PointCloud(points, attributes=unready), lambda: orbweave.Mesh(points, unready),
                         lambda: orbweave.PointCloud(points, attributes={"red": unready}),
                         lambda: orbweave.write_mesh("none.ply", mesh, origin=unready)):
                self.assertRaises(raised, call)

    def test_as_many_normals_as_points(self):
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.reconstruct(sphere(800), sphere(799))
        self.assertIn("799 normals for 800 positions", caught.exception.found)

    def test_no_normals_at_all_are_not_as_many_as_points(self):
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.reconstruct(sphere(800), numpy.zeros((0, 3)))
        self.assertEqual(caught.exception.place, "normals")

    def test_masked_values_are_refused(self):
        points = sphere(800)
        for place, arguments in (("points", (numpy.ma.masked_greater(points, 0.9),)),
                                 ("normals", (points, numpy.ma.masked_greater(points, 0.9)))):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(*arguments)
            self.assertEqual(caught.exception.place, place)
        self.same(numpy.ma.masked_array(points))

    def test_names_of_attributes_need_not_be_unicode(self):
        cloud = orbweave.PointCloud(sphere(10), attributes={"intensit\udce4t": numpy.arange(10)})
        orbweave.write_points("latin1.ply", cloud)
        self.assertIn(b"intensit\xe4t\n", pathlib.Path("latin1.ply").read_bytes())
        self.assertEqual(list(orbweave.read_points("latin1.ply").attributes), ["intensit\udce4t"])
        with self.assertRaises(orbweave.UsageError):
            orbweave.PointCloud(sphere(10), attributes={"\ud800": numpy.arange(10)})

    def test_attributes_are_a_dictionary(self):
        for wrong in (5, sphere(800)):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(sphere(800), attributes=wrong)
            self.assertEqual(caught.exception.place, "attributes")
        orbweave.reconstruct(sphere(800), attributes=types.MappingProxyType({"height": numpy.zeros(800)}))

    def test_names_of_attributes_are_texts(self):
        for wrong in (b"reflectance", 3, None, ("a", "b")):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.PointCloud(sphere(10), attributes={wrong: numpy.arange(10)})
            self.assertEqual((caught.exception.place, caught.exception.found), ("attributes", repr(wrong)))

    def test_an_attribute_is_a_number_per_point(self):
        for wrong in (numpy.zeros(799), numpy.zeros((800, 1)), ["a"] * 800):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.reconstruct(sphere(800), attributes={"red": wrong})
            self.assertIn("red", caught.exception.place)


class ArraysOut(unittest.TestCase):
    def test_vertices_are_points_of_the_cloud(self):
        points = sphere(800)
        mesh = orbweave.reconstruct(points)
        self.assertEqual(mesh.vertices.dtype, numpy.float64)
        self.assertEqual(mesh.triangles.dtype, numpy.uint32)
        self.assertEqual(mesh.vertices.shape[1], 3)
        self.assertEqual(mesh.triangles.shape[1], 3)
        self.assertLessEqual({tuple(row) for row in mesh.vertices[:800]}, {tuple(row) for row in points})

    def test_arrays_are_views_of_the_mesh_and_keep_it_alive(self):
        mesh = orbweave.reconstruct(sphere(800))
        views = [mesh.vertices, mesh.triangles, mesh.triangle_hole, mesh.normals]
        self.assertEqual(mesh.vertices.ctypes.data, views[0].ctypes.data)
        for view in views:
            self.assertFalse(view.flags.owndata)
            self.assertFalse(view.flags.writeable)
            self.assertIs(view.base, mesh)
        copies = [view.copy() for view in views]
        del mesh
        gc.collect()
        for view, copy in zip(views, copies):
            self.assertTrue(numpy.array_equal(view, copy))

    def test_columns_of_attributes_are_views_too(self):
        attributes = {name: numpy.arange(800).astype(name) for name in ("uint8", "int16", "float32", "float64")}
        cloud = orbweave.PointCloud(sphere(800), attributes=attributes)
        self.assertEqual(list(cloud.attributes), list(attributes))
        for name, values in attributes.items():
            self.assertEqual(cloud.attributes[name].dtype.name, name)
            self.assertTrue(numpy.array_equal(cloud.attributes[name], values))
            self.assertFalse(cloud.attributes[name].flags.owndata)


if __name__ == "__main__":
    unittest.main(verbosity=2)
