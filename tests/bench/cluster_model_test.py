"""Tests of bench/models/cluster_model.py: schedules and transfers whose seconds can be worked out by hand."""
import dataclasses
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench" / "models"))
import cluster_model  # noqa: E402
import stage_kinds  # noqa: E402
from cluster_model import (Cluster, Task, TaskShares, bytes_moved, calls_of, counter_calls, job_seconds,  # noqa: E402
                           makespan, stages_of)


def computing(*seconds):
    return [Task(s, 0.0, 0.0) for s in seconds]


def at_once(workers, **more):
    return Cluster(workers=workers, task_seconds=0.0, stage_seconds=0.0, **more)


def report(stages):
    return {"stages": [{"name": name, "seconds": seconds, "chunk_seconds": chunks, "bytes_read": 0, "bytes_written": 0}
                       for name, seconds, chunks in stages]}


class ClusterModel(unittest.TestCase):
    def test_longest_tasks_start_first(self):
        self.assertAlmostEqual(makespan(computing(1, 2, 2, 3), at_once(2)), 4.0)
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1, 4), at_once(2)), 4.0)

    def test_more_workers_than_tasks_gain_nothing(self):
        self.assertAlmostEqual(makespan(computing(1, 2), at_once(1000)), 2.0)

    def test_threads_are_workers_that_slow_each_other_down(self):
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1), at_once(2, threads=2, slowdown=0.1)), 1.1)

    def test_workers_of_one_machine_share_its_cores(self):
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1), at_once(4, cores=2)), 2.0)

    def test_transfers_share_the_storage(self):
        tasks = [Task(0.0, 10.0, 0.0), Task(0.0, 20.0, 0.0)]
        self.assertAlmostEqual(makespan(tasks, at_once(2, storage_bandwidth=10.0)), 3.0)

    def test_a_worker_is_no_faster_than_its_own_link(self):
        tasks = [Task(0.0, 10.0, 0.0)] * 2
        self.assertAlmostEqual(makespan(tasks, at_once(2, storage_bandwidth=1000.0, worker_bandwidth=5.0)), 2.0)

    def test_reading_computing_and_writing_follow_each_other(self):
        self.assertAlmostEqual(makespan([Task(1.0, 10.0, 20.0)], at_once(1, storage_bandwidth=10.0)), 4.0)

    def test_every_task_pays_for_the_counter(self):
        self.assertAlmostEqual(makespan(computing(1, 1), Cluster(workers=1, task_seconds=0.5)), 3.0)

    def test_the_counter_gives_out_one_task_at_a_time(self):
        cluster = Cluster(workers=4, task_seconds=0.0, counter_seconds=0.25)
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1), dataclasses.replace(cluster, by_blocks=False)), 2.0)

    def test_a_worker_needs_no_call_for_what_it_has_by_its_number(self):
        cluster = Cluster(workers=4, task_seconds=0.0, counter_seconds=0.25)
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1), cluster), 1.0)
        self.assertEqual(counter_calls(computing(1, 1, 1, 1), cluster), 0)

    def test_a_stage_ends_when_all_workers_know_that_nothing_is_left(self):
        # The first gets the fifth task, the others ask for another one in vain.
        cluster = Cluster(workers=4, task_seconds=0.0, counter_seconds=0.5)
        self.assertAlmostEqual(makespan(computing(1, 1, 1, 1, 0.25), cluster), 1.0 + 4 * 0.5)

    def test_a_worker_takes_a_block_by_one_call(self):
        shares = TaskShares([1] * 16, 2, 1)
        self.assertEqual(shares.begins, [0, 4, 8])
        self.assertEqual([shares.of_call(8, wanted, 0) for wanted in (0.0, 3.0, 100.0)], [2, 3, 4])
        cluster = Cluster(workers=2, task_seconds=0.0, counter_seconds=1.0)
        # Both get half of eight tasks; the second waits for its block.
        self.assertAlmostEqual(makespan(computing(*[0.0] * 8), at_once(2)), 0.0)
        self.assertLess(makespan(computing(*[0.01] * 64), cluster),
                        makespan(computing(*[0.01] * 64), dataclasses.replace(cluster, by_blocks=False)) / 2)

    def test_blocks_are_those_of_the_program(self):
        def calls(workers, wanted):
            shares = TaskShares([1] * 7400, workers, 16)
            seen, latest, given, blocks = [shares.begins[-1]] * workers, [0] * workers, shares.begins[-1], 0
            while given < 7400:
                for worker in range(workers):
                    end = min(given + shares.of_call(seen[worker], wanted, latest[worker]), 7400)
                    blocks += given < end
                    latest[worker] = end - given
                    given = seen[worker] = end
            return blocks
        # tests/partition/task_shares_test.cpp has the same.
        self.assertEqual([calls(workers, 0.0) for workers in (2, 64, 1000)], [32, 668, 0])
        self.assertEqual(calls(64, 1e9), 65)
        self.assertEqual(counter_calls(computing(*[1.0] * 7400), at_once(1)), 0)

    def test_blocks_that_are_soon_done_are_larger(self):
        cluster = Cluster(workers=64, threads=16, counter_seconds=0.005)
        self.assertLess(counter_calls(computing(*[0.001] * 7400), cluster),
                        counter_calls(computing(*[10.0] * 7400), cluster) / 2)

    def test_counts_are_merged_in_pairs(self):
        stages = stages_of(report([("count", 0.0, [])]))
        self.assertAlmostEqual(job_seconds(stages, at_once(64))["count"], 6 * 0.02)
        self.assertAlmostEqual(job_seconds(stages, at_once(64, by_tree=False))["count"], 64 * 0.02)
        self.assertAlmostEqual(job_seconds(stages, at_once(1))["count"], 0.0)

    def test_bytes_of_a_team_are_those_that_one_counted(self):
        measured = report([("bin", 1.0, []), ("reconstruct", 4.0, [1.0] * 4), ("trace", 1.0, [])])
        team = {"ranks": 2, "stages": [{"name": "bin", "bytes_read": 10, "bytes_written": 5},
                                       {"name": "trace", "bytes_read": 8, "bytes_written": 0}]}
        stages = stages_of(measured, team=team)
        self.assertEqual(bytes_moved(stages, at_once(1)), 0)
        self.assertEqual(bytes_moved(stages, at_once(3)), 15 + 3 * 4)
        self.assertEqual(calls_of(stages, at_once(2)), 2 + 1)

    def test_count_grids_are_as_many_as_workers_and_no_larger_for_more_points(self):
        team = {"ranks": 2, "stages": [{"name": "count", "bytes_read": 6, "bytes_written": 4}]}
        counts = stages_of(report([("count", 1.0, [])]), team=team)[0]
        self.assertEqual(bytes_moved([counts], at_once(1)), 0)
        self.assertEqual(bytes_moved([counts.grown(10)], at_once(8)), 8 * 5)

    def test_one_worker_takes_what_was_measured(self):
        measured = report([("count", 2.0, []), ("reconstruct", 7.0, [1.0, 2.0, 3.0]), ("stitch", 1.0, [])])
        stages = stages_of(measured, outside_seconds=0.5)
        self.assertAlmostEqual(sum(job_seconds(stages, at_once(1)).values()), 10.5)

    def test_what_the_leader_does_is_not_divided(self):
        stages = stages_of(report([("orient", 5.0, []), ("reconstruct", 8.0, [1.0] * 8)]))
        seconds = job_seconds(stages, at_once(8))
        self.assertAlmostEqual(seconds["orient"], 5.0)
        self.assertAlmostEqual(seconds["reconstruct"], 1.0)

    def test_a_grown_job_has_as_much_more_work(self):
        stages = stages_of(report([("reconstruct", 6.0, [1.0, 2.0, 3.0])]))
        self.assertAlmostEqual(sum(job_seconds([stages[0].grown(2.5)], at_once(1)).values()), 15.0)
        self.assertEqual(len(stages[0].grown(10).chunk_seconds), 30)

    def test_what_any_job_takes_of_a_stage_does_not_grow(self):
        fixed = stage_kinds.KINDS["orient"].fixed
        self.assertGreater(fixed, 0.0)
        stages = stages_of(report([("orient", fixed + 1.0, [])]))
        self.assertAlmostEqual(stages[0].grown(10).seconds, fixed + 10.0)
        small = stages_of(report([("orient", 0.5 * fixed, [])]))
        self.assertAlmostEqual(small[0].grown(10).seconds, 0.5 * fixed)

    def test_every_process_does_what_no_chunk_accounts_for_with_all_its_threads(self):
        stages = stages_of(report([("reconstruct", 16.0, [1.0] * 8)]))
        self.assertAlmostEqual(job_seconds(stages, at_once(2, threads=4))["reconstruct"], 2.0 + 1.0)

    def test_a_busy_machine_is_known_by_its_cpu_seconds(self):
        busy = {"stages": [
            # Half of the chunks' time was somebody else's; the disk was waited for, and a thread flushed meanwhile.
            {"name": "reconstruct", "seconds": 5.0, "cpu_seconds": 2.3, "chunk_seconds": [2.0, 2.0],
             "chunk_cpu_seconds": [1.0, 1.0], "bytes_read": 0, "bytes_written": 0},
            {"name": "stitch", "seconds": 3.0, "cpu_seconds": 1.0, "bytes_read": 0, "bytes_written": 0}]}
        stages = cluster_model.unhindered(busy)["stages"]
        self.assertAlmostEqual(stages[0]["seconds"], 2.3)
        self.assertEqual(stages[0]["chunk_seconds"], [1.0, 1.0])
        self.assertAlmostEqual(stages[1]["seconds"], 1.0)

    def test_kinds_of_stages_can_be_told(self):
        measured = report([("stitch", 4.0, [])])
        shared = stages_of(measured, overrides={"stitch": "shared"})
        self.assertAlmostEqual(job_seconds(stages_of(measured), at_once(4))["stitch"], 4.0)
        self.assertAlmostEqual(job_seconds(shared, at_once(4))["stitch"], 1.0)


if __name__ == "__main__":
    unittest.main()
