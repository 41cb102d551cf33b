"""Meshes, clouds and holes: made, read, written, counted."""
import ast
import copy
import inspect
import pathlib
import pickle
import typing
import unittest
import warnings

import numpy
import orbweave
from support import bytes_of, program, sphere

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

    def test_the_numbers_of_an_xdmf_file_replace_no_other_file(self):
        mesh = orbweave.Mesh(*TETRAHEDRON)
        pathlib.Path("data.h5").write_text("measurements", encoding="ascii")
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.write_mesh("data.xdmf", mesh)
        self.assertEqual(caught.exception.file, "data.h5")
        self.assertEqual(bytes_of("data.h5"), b"measurements")
        for _ in range(2):
            orbweave.write_mesh("other.xdmf", mesh)

    def test_a_format_without_a_text_encoding_is_told(self):
        for name in ("t.glb", "t.vtp", "t.xdmf"):
            with self.assertRaisesRegex(orbweave.UsageError, "no text encoding"):
                orbweave.write_mesh(name, orbweave.Mesh(*TETRAHEDRON), binary=False)
            self.assertFalse(pathlib.Path(name).exists())

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
        for wrong in ([1.7] * 4, [2**40] * 4, [1, 2], ["a"] * 4, object(), numpy.full(4, 2**64 - 1, dtype=numpy.uint64)):
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
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.Mesh(TETRAHEDRON[0], numpy.array([[0, 1, 2**64 - 1]], dtype=numpy.uint64))
        self.assertEqual((caught.exception.place, caught.exception.found), ("triangles", str(2**64 - 1)))

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


class Help(unittest.TestCase):
    def test_every_member_has_a_docstring(self):
        for type_ in (orbweave.Hole, orbweave.Mesh, orbweave.PointCloud):
            for name, member in vars(type_).items():
                self.assertTrue(name.startswith("_") or member.__doc__, f"{type_.__name__}.{name}")


class Stubs(unittest.TestCase):
    """What editors and type checkers take the module for."""

    def stub(self, name):
        return ast.parse((pathlib.Path(orbweave.__file__).parent / name).read_text(encoding="utf-8")).body

    def test_stubs_name_what_the_module_has(self):
        for node in self.stub("__init__.pyi"):
            if isinstance(node, ast.FunctionDef):
                parameters = inspect.signature(getattr(orbweave, node.name)).parameters.values()
                kinds = {kind: [p.name for p in parameters if p.kind == kind] for kind in (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)}
                self.assertEqual([[a.arg for a in node.args.args], [a.arg for a in node.args.kwonlyargs]], list(kinds.values()), node.name)
            for target in getattr(node, "targets", []):
                if target.id == "__all__":
                    self.assertEqual(ast.literal_eval(node.value), orbweave.__all__)
                elif not target.id.startswith("_"):
                    self.assertTrue(hasattr(orbweave, target.id), target.id)

    def test_the_parts_of_errors_are_texts_to_a_type_checker(self):
        hints = typing.get_type_hints(orbweave.OrbweaveError.__init__)
        parts = ("message", "problem", "file", "place", "found", "expected", "advice")
        self.assertEqual(hints, dict.fromkeys(parts, str) | {"return": type(None)})
        self.assertEqual(typing.get_type_hints(orbweave.OrbweaveError), {"exit_status": int})

    def test_stubs_of_classes_name_their_members(self):
        for node in self.stub("_orbweave.pyi"):
            if isinstance(node, ast.ClassDef):
                members = {name for name in vars(getattr(orbweave, node.name)) if not name.startswith("_")}
                self.assertEqual({f.name for f in node.body if not f.name.startswith("_")}, members, node.name)


class Scan(orbweave.PointCloud):
    station = 7


class Part(orbweave.Mesh):
    station = 7


class Travellers(unittest.TestCase):
    def twins(self, thing):
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            yield pickle.loads(pickle.dumps(thing, protocol))
        yield copy.copy(thing)
        yield copy.deepcopy(thing)

    def test_a_cloud_is_pickled_and_copied(self):
        attributes = {"red": numpy.arange(500, dtype=numpy.uint8), "intensit\udce4t": numpy.arange(500.0)}
        cloud = orbweave.PointCloud(sphere(500), sphere(500).astype(numpy.float32), attributes=attributes, coordinate_system="EPSG:25832")
        orbweave.write_points("cloud.ply", cloud)
        for twin in self.twins(cloud):
            self.assertEqual(twin.coordinate_system, "EPSG:25832")
            orbweave.write_points("twin.ply", twin)
            self.assertEqual(bytes_of("twin.ply"), bytes_of("cloud.ply"))

    def test_a_mesh_is_pickled_with_what_is_known_of_it(self):
        points = sphere(2000)
        mesh = orbweave.reconstruct(numpy.vstack([points[points[:, 2] < 0.8], [[numpy.nan, 0, 0]]]))
        orbweave.write_mesh("mesh.ply", mesh)
        for twin in self.twins(mesh):
            orbweave.write_mesh("twin.ply", twin)
            self.assertEqual(bytes_of("twin.ply"), bytes_of("mesh.ply"))
            self.assertEqual((twin.ball_radii, twin.dropped), (mesh.ball_radii, mesh.dropped))
            self.assertEqual(len(twin.holes), len(mesh.holes))
            for hole, expected in zip(twin.holes, mesh.holes):
                for name in (name for name in dir(expected) if not name.startswith("_")):
                    self.assertEqual(getattr(hole, name), getattr(expected, name), name)
        self.assertEqual(pickle.loads(pickle.dumps(mesh.holes[0])).center, mesh.holes[0].center)

    def test_what_a_subclass_adds_goes_along(self):
        scan = Scan(sphere(50), sphere(50))
        part = Part(*TETRAHEDRON)
        for thing, count in ((scan, 50), (part, 4)):
            thing.notes = ["of the tower"]
            for twin in self.twins(thing):
                self.assertIs(type(twin), type(thing))
                self.assertEqual((twin.notes, twin.station), (["of the tower"], 7))
                self.assertEqual(len(twin.normals if count == 50 else twin.vertices), count)
                twin.station = 8
            self.assertEqual(thing.station, 7)
            self.assertIs(copy.copy(thing).notes, thing.notes)
            self.assertIsNot(copy.deepcopy(thing).notes, thing.notes)

    def test_a_damaged_pickle_is_refused(self):
        state = orbweave.PointCloud(sphere(500)).__getstate__()
        cut = (state[0][:1] + (state[0][1][:-1],) + state[0][2:],) + state[1:]
        with self.assertRaises(orbweave.UsageError):
            orbweave.PointCloud.__new__(orbweave.PointCloud).__setstate__(cut)
        state = orbweave.Mesh(*TETRAHEDRON, triangle_hole=[0, 0, 0, 1]).__getstate__()
        stray = numpy.array([[0, 2, 4]] * 4, dtype=numpy.uint32).tobytes()
        for damaged in ((state[0], stray) + state[2:], state[:2] + (state[2][4:],) + state[3:]):
            with self.assertRaises(orbweave.UsageError):
                orbweave.Mesh.__new__(orbweave.Mesh).__setstate__(damaged)


class CoordinateSystems(unittest.TestCase):
    def test_a_system_may_be_named_as_proj_understands_it(self):
        expected = orbweave.PointCloud(sphere(10), coordinate_system="EPSG:25832").coordinate_system
        self.assertEqual(expected, "EPSG:25832")
        for name in ("epsg:25832", "urn:ogc:def:crs:EPSG::25832", "ETRS89 / UTM zone 32N"):
            self.assertEqual(orbweave.PointCloud(sphere(10), coordinate_system=name).coordinate_system, expected)
            self.assertEqual(orbweave.Mesh(*TETRAHEDRON, coordinate_system=name).coordinate_system, expected)
        utm = orbweave.PointCloud(sphere(10), coordinate_system="+proj=utm +zone=32 +ellps=GRS80")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            orbweave.write_points("utm.ply", utm)
        self.assertIn("Transverse_Mercator", pathlib.Path("utm.prj").read_text(encoding="utf-8"))
        self.assertEqual(orbweave.PointCloud(sphere(10), coordinate_system="of the site").coordinate_system, "of the site")

    def test_a_system_goes_from_the_cloud_to_the_mesh_and_its_file(self):
        orbweave.write_points("c.ply", orbweave.PointCloud(sphere(500), sphere(500), coordinate_system="EPSG:25832"))
        cloud = orbweave.read_points("c.ply")
        mesh = orbweave.reconstruct(cloud)
        self.assertEqual(mesh.coordinate_system, cloud.coordinate_system)
        self.assertIn("25832", mesh.coordinate_system)
        orbweave.write_mesh("m.ply", mesh)
        program("reconstruct", "c.ply", "-o", "program.ply", "--progress", "none")
        self.assertEqual(bytes_of("m.prj"), bytes_of("program.prj"))
        self.assertEqual(orbweave.read_mesh("m.ply").coordinate_system, mesh.coordinate_system)

    def test_a_system_that_an_earlier_file_left_is_warned_of(self):
        cloud = orbweave.PointCloud(sphere(500))
        pathlib.Path("stale.prj").write_text("EPSG:25832\n", encoding="ascii")
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, "stale.prj was there before .* the cloud tells of none") as caught:
            orbweave.write_points("stale.ply", cloud)
        self.assertEqual(caught.filename, __file__)
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, "PROJ does not know it"):
            orbweave.write_points("words.ply", orbweave.PointCloud(sphere(500), coordinate_system="our own"))
        self.assertFalse(pathlib.Path("words.prj").exists())


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

    def test_what_a_file_holds_and_no_object_has_is_warned_of(self):
        pathlib.Path("lists.ply").write_text(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "property list uchar int marks\nelement face 1\nproperty list uchar int vertex_indices\nproperty float quality\n"
            "end_header\n0 0 0 1 7\n1 0 0 0\n0 1 0 0\n3 0 1 2 0.5\n", encoding="ascii")
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, "lists.ply: not carried over: vertex list marks") as caught:
            self.assertEqual(len(orbweave.read_points("lists.ply")), 3)
        self.assertEqual(caught.filename, __file__)
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, "lists.ply: not carried over: .*quality"):
            self.assertEqual(len(orbweave.read_mesh("lists.ply").triangles), 1)

    def test_the_place_of_a_scanner_is_told_and_turns_normals(self):
        points = "".join(f"{x} {y} {2 + 0.01 * (x % 3)} 0.5\n" for x in range(20) for y in range(20))
        head = "20\n20\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n100 200 300 1\n"
        pathlib.Path("room.ptx").write_text(head + points, encoding="ascii")
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, r"scanners=\[\[100, 200, 300\]\]") as caught:
            cloud = orbweave.read_points("room.ptx")
        self.assertEqual(caught.filename, __file__)
        orbweave.write_mesh("room.ply", orbweave.reconstruct(cloud, scanners=[[100, 200, 300]]))
        program("reconstruct", "room.ptx", "-o", "program.ply", "--progress", "none")
        self.assertEqual(bytes_of("room.ply"), bytes_of("program.ply"))
        pathlib.Path("rooms.ptx").write_text(2 * (head + points), encoding="ascii")
        with self.assertWarnsRegex(orbweave.OrbweaveWarning, "the places of 2 scanners"):
            orbweave.read_points("rooms.ptx")

    def test_a_cloud_brings_its_normals_itself(self):
        with self.assertRaises(orbweave.UsageError):
            orbweave.reconstruct(orbweave.PointCloud(sphere(500)), sphere(500))


if __name__ == "__main__":
    unittest.main(verbosity=2)
