"""Failures are exceptions with their parts, of the class of the program's exit status."""
import enum
import os
import pathlib
import pickle
import subprocess
import sys
import unittest

import numpy
import orbweave
from support import sphere


class Errors(unittest.TestCase):
    def test_an_option_out_of_range_is_wrong_usage(self):
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.reconstruct(sphere(500), levels=9)
        self.assertIsInstance(caught.exception, ValueError)
        self.assertEqual(caught.exception.exit_status, 2)
        self.assertIn("reconstruct.levels", str(caught.exception))
        self.assertEqual(caught.exception.found, "9")
        self.assertEqual(caught.exception.expected, '"auto" or an integer from 1 to 8')

    def test_an_option_of_a_wrong_type_is_wrong_usage(self):
        for wrong in ({"levels": "many"}, {"fill": 1}, {"kernel": "cubic"}, {"up": [0, 0]}, {"up": object()}, {"ball_radii": [2, 1]}):
            with self.assertRaises(orbweave.UsageError):
                orbweave.reconstruct(sphere(500), **wrong)

    def test_a_number_of_an_enumeration_is_a_number(self):
        class Number(enum.IntEnum):
            TWO = 2
            NINE = 9

        class Length(float):
            def __repr__(self):
                return f"{float(self)} m"
        points = sphere(500)
        expected = orbweave.reconstruct(points, levels=2, neighborhood=2.5)
        mesh = orbweave.reconstruct(points, levels=Number.TWO, neighborhood=Length(2.5))
        self.assertTrue(numpy.array_equal(mesh.triangles, expected.triangles))
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.reconstruct(points, levels=Number.NINE)
        self.assertEqual(caught.exception.found, "9")

    def test_a_flag_is_true_or_false(self):
        cloud, mesh = orbweave.PointCloud(sphere(10)), orbweave.Mesh(sphere(10), [[0, 1, 2]])
        for name, call in (("binary", lambda flag: orbweave.write_points("f.ply", cloud, binary=flag)),
                           ("float_positions", lambda flag: orbweave.write_mesh("f.ply", mesh, float_positions=flag)),
                           ("fresh", lambda flag: orbweave.run("[input]\n", fresh=flag))):
            for wrong in ("no", [True], 0.5, numpy.zeros(2, dtype=bool)):
                with self.assertRaises(orbweave.UsageError) as caught:
                    call(wrong)
                self.assertEqual((caught.exception.place, caught.exception.found), (name, repr(wrong)))
        orbweave.write_points("f.ply", cloud, binary=numpy.bool_(False))
        self.assertIn(b"format ascii", pathlib.Path("f.ply").read_bytes())

    def test_messages_about_normals_name_the_words_of_python(self):
        for wrong in ({"orientation": "scanner"}, {"orientation": "viewpoint"}, {"source": "poles"}, {"source": "file"}):
            with self.assertRaises(orbweave.OrbweaveError) as caught:
                orbweave.reconstruct(sphere(500), **wrong)
            self.assertNotIn("::", str(caught.exception))

    def test_no_points_are_bad_input(self):
        with self.assertRaises(orbweave.BadInputError) as caught:
            orbweave.reconstruct(numpy.zeros((0, 3)))
        self.assertEqual(caught.exception.exit_status, 3)

    def test_a_damaged_file_is_bad_input_with_file_and_place(self):
        pathlib.Path("bad.ply").write_text("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n", encoding="ascii")
        with self.assertRaises(orbweave.BadInputError) as caught:
            orbweave.read_points("bad.ply")
        self.assertEqual(caught.exception.file, "bad.ply")
        self.assertTrue(caught.exception.problem)

    def test_a_job_file_with_a_mistake_names_file_line_and_advice(self):
        pathlib.Path("job.toml").write_text("[fill]\nmax_edge = 3\n", encoding="utf-8")
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.plan("job.toml")
        error = caught.exception
        self.assertEqual((error.file, error.place, error.advice), ("job.toml", "line 2", "Did you mean fill.max_edges?"))

    def test_a_path_that_is_no_utf8_comes_back_as_it_was(self):
        name = b"\xff.ply"
        with self.assertRaises(orbweave.BadInputError) as caught:
            orbweave.read_points(name)
        self.assertEqual(caught.exception.file.encode("utf-8", "surrogateescape"), name)

    def test_a_path_with_a_zero_byte_is_refused(self):
        cloud = orbweave.PointCloud(sphere(10))
        mesh = orbweave.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        for call in (lambda name: orbweave.write_points(name, cloud), lambda name: orbweave.write_mesh(name, mesh),
                     orbweave.read_points, orbweave.read_mesh, orbweave.plan, orbweave.run):
            for name in ("cut\0.ply", b"cut\0.ply", pathlib.Path("cut\0.ply")):
                with self.assertRaisesRegex(orbweave.UsageError, "no zero bytes"):
                    call(name)
        self.assertFalse(pathlib.Path("cut").exists())

    def test_a_full_device_is_a_lack_of_resources(self):
        mesh = orbweave.reconstruct(sphere(500))
        with self.assertRaises(orbweave.ResourceError) as caught:
            orbweave.write_mesh("no/such/folder/mesh.ply", mesh)
        self.assertEqual(caught.exception.exit_status, 4)

    def test_an_origin_that_is_no_place_is_wrong_usage(self):
        mesh = orbweave.reconstruct(sphere(500))
        cloud = orbweave.PointCloud(sphere(500))
        for origin in ((0, 0), (0, 0, 0, 0), (0, 0, float("nan")), (float("inf"), 0, 0), "abc", 5, None, numpy.zeros((1, 3)), [None] * 3):
            for write, what in ((orbweave.write_mesh, mesh), (orbweave.write_points, cloud)):
                with self.assertRaises(orbweave.UsageError) as caught:
                    write("o.ply", what, origin=origin)
                self.assertEqual((caught.exception.place, caught.exception.expected), ("origin", "three finite numbers x, y, z"))
                self.assertFalse(pathlib.Path("o.ply").exists())

    def test_an_origin_too_far_for_the_numbers_of_the_file_is_wrong_usage(self):
        mesh = orbweave.reconstruct(sphere(500))
        alone = orbweave.Mesh([[1.0, 2.0, 3.0], [2.0, 2.0, 3.0]], numpy.zeros((0, 3), numpy.uint32))
        one = orbweave.PointCloud([[1.0, 2.0, 3.0]])
        for write, what in ((orbweave.write_mesh, mesh), (orbweave.write_mesh, alone), (orbweave.write_points, one)):
            with self.assertRaises(orbweave.UsageError) as caught:
                write("o.ply", what, origin=(1e20, 0, 0))
            self.assertEqual((caught.exception.file, caught.exception.place), ("o.ply", "origin"))
            self.assertIn("would move", caught.exception.problem)
            self.assertFalse(pathlib.Path("o.ply").exists())
            write("o.ply", what, origin=numpy.array([0.5, 0.1, 1000.0]))
            pathlib.Path("o.ply").unlink()
        with self.assertRaises(orbweave.UsageError):
            orbweave.write_mesh("o.stl", mesh, origin=(1e8, 0, 0))

    def test_floats_that_would_move_the_points_want_an_origin(self):
        far = orbweave.reconstruct(sphere(500) + [5e5, 4e6, 0])
        for name, settings in (("m.stl", {}), ("m.ply", {"float_positions": True})):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.write_mesh(name, far, **settings)
            self.assertEqual((caught.exception.file, caught.exception.place), (name, "origin"))
            self.assertFalse(pathlib.Path(name).exists())
            orbweave.write_mesh(name, far, origin=(5e5, 4e6, 0), **settings)
            self.assertLess(numpy.abs(orbweave.read_mesh(name).vertices.max(axis=0) - far.vertices.max(axis=0)).max(), 1e-6)
        rounded = orbweave.Mesh(far.vertices.astype(numpy.float32).astype(float), far.triangles)
        orbweave.write_mesh("rounded.stl", rounded)  # floats already
        near = orbweave.reconstruct(sphere(500))
        orbweave.write_mesh("near.stl", near)

    def test_a_thread_that_cannot_be_started_is_a_lack_of_resources(self):
        code = (f"import sys; sys.path.insert(0, {os.path.dirname(os.path.abspath(__file__))!r})\n"
                "import orbweave, resource\nfrom support import sphere\npoints = sphere(500)\n"
                "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
                "resource.setrlimit(resource.RLIMIT_AS, (used + 2**20,) * 2)\n"
                "try:\n    orbweave.reconstruct(points)\n"
                "except orbweave.ResourceError as error:\n    print(error.problem, '|', error.advice)\n")
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        self.assertEqual(done.stderr, "")
        self.assertRegex(done.stdout, "^the system starts no more threads [|] .*ulimit -v")

    def test_errors_of_other_modules_stay_theirs(self):
        sys.path.insert(0, os.environ["ORBWEAVE_FOREIGN_MODULE_DIR"])
        import foreign_module
        for call in (foreign_module.fail_in_the_system, foreign_module.fail):
            with self.assertRaises(RuntimeError) as caught:
                call()
            self.assertIs(type(caught.exception), RuntimeError)

    def test_errors_travel_between_processes(self):
        error = orbweave.UsageError("text", problem="p", file="f", place="line 2", found="x", expected="y", advice="z")
        twin = pickle.loads(pickle.dumps(error))
        self.assertEqual((type(twin), str(twin), twin.file, twin.advice), (orbweave.UsageError, "text", "f", "z"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
