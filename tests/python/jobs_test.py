"""Jobs from Python: files, texts, dictionaries; plans, reports, interruption and resumption."""
import os
import pathlib
import threading
import types
import unittest
import warnings

import numpy
import orbweave
from support import bytes_of, program, sphere


class Jobs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        orbweave.write_points("scan.ply", orbweave.PointCloud(sphere(3000), sphere(3000)))
        program("reconstruct", "scan.ply", "-o", "expected.ply", "--progress", "none")

    def check(self, report, mesh="mesh.ply"):
        self.assertEqual(bytes_of(mesh), bytes_of("expected.ply"))
        self.assertTrue(report["mesh"]["watertight"])
        pathlib.Path(mesh).unlink()

    def test_a_dictionary(self):
        self.check(orbweave.run({"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply"}}))

    def test_a_text(self):
        self.check(orbweave.run('[input]\nfiles = "scan.ply"\n[output]\nmesh = "mesh.ply"\n'))

    def test_a_file_and_paths_relative_to_it(self):
        os.makedirs("folder", exist_ok=True)
        pathlib.Path("folder/job.toml").write_text('[input]\nfiles = ["../scan.ply"]\n[output]\nmesh = "m.ply"\n', encoding="utf-8")
        self.check(orbweave.run(pathlib.Path("folder/job.toml")), "folder/m.ply")

    def test_settings_win_over_the_job(self):
        report = orbweave.run({"input": {"files": ["scan.ply"]}, "output": {"mesh": "other.ply"}, "run": {"threads": 2}},
                              settings={"output.mesh": pathlib.Path("mesh.ply"), "partition.chunk_points": numpy.int64(400)})
        self.assertEqual(report["options"]["partition"]["chunk_points"], 400)
        self.check(report)

    def test_flags_of_numpy_are_flags(self):
        settings = {"output.attributes": numpy.bool_(True), "fill.enabled": numpy.array([0.0, 1.0]).any()}
        report = orbweave.run({"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply"}}, settings=settings)
        self.assertIs(report["options"]["fill"]["enabled"], True)
        self.check(report)

    def test_a_table_is_a_dictionary(self):
        job = {"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply", "simplify": {"ratio": 0.5}}}
        self.check(orbweave.run(job))
        kept = bytes_of("mesh.simplified.ply")
        self.check(orbweave.run(job, settings={"output.simplify": types.MappingProxyType({"triangles": numpy.int64(2998)})}))
        self.assertEqual(bytes_of("mesh.simplified.ply"), kept)
        for wrong in ({}, {"ratio": 2.0}, {"rat io": 0.5}, {"ratio": 0.5, "error": 1.0}, {"ratio": b"0.5"}):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.run(job, settings={"output.simplify": wrong})
            self.assertTrue(caught.exception.expected)

    def test_progress_names_stages(self):
        stages = []
        orbweave.run({"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply"}},
                     progress=lambda stage, done: stages.append((stage, done)))
        names = {stage for stage, _ in stages}
        self.assertIn("reconstruct", names)
        self.assertTrue(all(0.0 <= done <= 1.0 for _, done in stages))

    def test_progress_never_goes_back(self):
        points = sphere(30000)
        orbweave.write_points("bare.ply", orbweave.PointCloud(points))
        told = []
        orbweave.run({"input": {"files": ["bare.ply"]}, "output": {"mesh": "bare-mesh.ply"}, "partition": {"chunk_points": 3000}},
                     progress=lambda stage, done: told.append(done))
        self.assertEqual(told, sorted(told))
        self.assertGreater(told[-1], 0.5)

    def test_a_stopped_run_resumes_to_the_same_bytes(self):
        job = {"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply"}, "partition": {"chunk_points": 300}}

        def stop(stage, done):
            if stage == "reconstruct":
                raise InterruptedError
        with self.assertRaises(InterruptedError):
            orbweave.run(job, progress=stop)
        self.assertFalse(pathlib.Path("mesh.ply").exists())
        self.check(orbweave.run(job))

    def test_a_plan_writes_nothing(self):
        before = sorted(os.listdir())
        plan = orbweave.plan({"input": {"files": ["scan.ply"]}, "output": {"mesh": "planned.ply"}})
        self.assertEqual(sorted(os.listdir()), before)
        self.assertEqual(plan["points"], 3000)
        self.assertGreater(plan["peak_memory_bytes"], 0)
        self.assertIsNone(plan["holes"])
        self.assertEqual(plan["doubts"], [])
        for key in plan:
            self.assertRegex(orbweave.plan.__doc__, rf"\b{key}\b")

    def test_a_job_without_scans_is_wrong_usage(self):
        with self.assertRaises(orbweave.UsageError) as caught:
            orbweave.run({"output": {"mesh": "mesh.ply"}})
        self.assertEqual(caught.exception.place, "input.files")
        with self.assertRaises(orbweave.UsageError):
            orbweave.run({"output": "mesh.ply"})

    def test_a_job_that_cannot_end_is_refused_before_the_work(self):
        for output in ({}, {"mesh": "mesh.xyz"}, {"mesh": "mesh"}):
            with self.assertRaises(orbweave.UsageError):
                orbweave.run({"input": {"files": ["scan.ply"]}, "output": output})
        self.assertFalse([name for name in os.listdir() if name.endswith(".work")])

    def test_sections_and_settings_are_dictionaries_of_any_kind(self):
        job = types.MappingProxyType({"input": types.MappingProxyType({"files": ["scan.ply"]})})
        self.check(orbweave.run(job, settings=types.MappingProxyType({"output.mesh": "mesh.ply"})))
        for wrong in ([("output.mesh", "mesh.ply")], {3: "mesh.ply"}):
            with self.assertRaises(orbweave.UsageError):
                orbweave.run(job, settings=wrong)

    def test_a_scan_whose_name_is_no_unicode_is_named_by_a_pattern(self):
        name = os.fsdecode(b"\xffscan.ply")
        orbweave.write_points(name, orbweave.PointCloud(sphere(3000), sphere(3000)))
        self.assertEqual(orbweave.plan({"input": {"files": ["?scan.ply"]}})["files"], [name])
        for job, settings in (({"input": {"files": [name]}}, {}), ({}, {"input.files": name}), (f'[input]\nfiles = ["{name}"]\n', {})):
            with self.assertRaises(orbweave.UsageError) as caught:
                orbweave.plan(job, settings=settings)
            self.assertIn("Unicode", caught.exception.expected)
        os.unlink(name)

    def test_the_defaults_are_a_job(self):
        self.check(orbweave.run(orbweave.job_defaults(), settings={"input.files": "scan.ply", "output.mesh": "mesh.ply"}))

    def test_warnings_of_a_run_are_warnings(self):
        points = sphere(3000) * 1e-3
        orbweave.write_points("small.ply", orbweave.PointCloud(points, points))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            report = orbweave.run({"input": {"files": ["small.ply"], "units_per_meter": 1e6}, "output": {"mesh": "small-mesh.ply"}})
        texts = [str(warning.message) for warning in caught if issubclass(warning.category, orbweave.OrbweaveWarning)]
        self.assertEqual(texts, report.get("warnings", texts))


if __name__ == "__main__":
    unittest.main(verbosity=2)
