"""Callbacks, Ctrl-C and other threads of Python while the library works."""
import os
import signal
import tempfile
import threading
import time
import unittest

import numpy

import orbweave
from support import sphere


class WhileTheLibraryWorks(unittest.TestCase):
    def test_progress_names_the_stages_in_their_order(self):
        told = []
        orbweave.reconstruct(sphere(800), progress=lambda stage, done: told.append((stage, done)))
        self.assertEqual([stage for stage, _ in told], ["measure", "sort", "normals", "orient", "reconstruct", "fill"])
        self.assertEqual(sorted(done for _, done in told), [done for _, done in told])
        self.assertTrue(all(0.0 <= done < 1.0 for _, done in told))

    def test_progress_is_called_in_the_thread_of_the_caller(self):
        threads = set()
        orbweave.reconstruct(sphere(800), progress=lambda stage, done: threads.add(threading.get_ident()))
        self.assertEqual(threads, {threading.get_ident()})

    def test_what_progress_raises_ends_the_call(self):
        def refuse(stage, done):
            raise ZeroDivisionError(stage)
        with self.assertRaises(ZeroDivisionError):
            orbweave.reconstruct(sphere(800), progress=refuse)

    def test_ctrl_c_stops_the_work(self):
        points = sphere(300000)
        begin = time.monotonic()
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            orbweave.reconstruct(points)
        self.assertLess(time.monotonic() - begin, 20.0)

    def test_ctrl_c_stops_reading(self):
        def feed(pipe, front, piece):
            """Writes slowly, until the reader goes."""
            try:
                with open(pipe, "wb", buffering=0) as file:
                    file.write(front)
                    for _ in range(600):
                        file.write(piece)
                        time.sleep(0.005)
            except BrokenPipeError:
                cut.append(pipe)
        rows = b"0.5 0.25 0.125\n" * 4000
        header = (b"ply\nformat ascii 1.0\nelement vertex 2400000\nproperty double x\nproperty double y\n"
                  b"property double z\nend_header\n")
        for name, front, read in (("mesh.ply", header, orbweave.read_mesh), ("cloud.xyz", b"", orbweave.read_points)):
            with tempfile.TemporaryDirectory() as folder:
                pipe, cut = os.path.join(folder, name), []
                os.mkfifo(pipe)
                feeder = threading.Thread(target=feed, args=(pipe, front, rows))
                feeder.start()
                threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
                with self.assertRaises(KeyboardInterrupt):
                    read(pipe)
                feeder.join()
                self.assertEqual(cut, [pipe], "the whole file was read")

    def test_signals_are_seen_while_facts_are_counted(self):
        rows = columns = 2000  # enough for many looks at signals, one each 50 ms
        row, column = numpy.mgrid[0:rows, 0:columns]
        corner = (row * columns + column)[:-1, :-1].ravel()
        triangles = numpy.concatenate([numpy.stack([corner, corner + 1, corner + columns], axis=1),
                                    numpy.stack([corner + 1, corner + columns + 1, corner + columns], axis=1)])
        mesh = orbweave.Mesh(numpy.stack([row, column, 0 * row], axis=2).reshape(-1, 3).astype(float), triangles)
        seen = []
        before = signal.signal(signal.SIGALRM, lambda *_: seen.append(time.monotonic()))
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.01, 0.01)
            facts = mesh.facts()
            signal.setitimer(signal.ITIMER_REAL, 0)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        self.assertEqual(facts["triangles"], len(triangles))
        self.assertGreater(len(seen), 2, "signals wait for the end of the call")

    def test_ctrl_c_ends_facts(self):
        mesh = orbweave.reconstruct(sphere(800))

        def interrupt(*_):
            raise KeyboardInterrupt
        before = signal.signal(signal.SIGALRM, interrupt)
        try:
            with self.assertRaises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, 0.05)
                while True:
                    mesh.facts()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)

    def test_other_threads_run_meanwhile(self):
        points, ticks = sphere(20000), []
        ended = threading.Event()

        def tick():
            while not ended.wait(0.001):
                ticks.append(1)
        ticker = threading.Thread(target=tick)
        ticker.start()
        before = len(ticks)
        orbweave.reconstruct(points)
        during = len(ticks) - before
        ended.set()
        ticker.join()
        self.assertGreater(during, 0)

    def test_several_threads_call_at_once(self):
        points, meshes = sphere(800), []
        threads = [threading.Thread(target=lambda: meshes.append(orbweave.reconstruct(points))) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len({mesh.triangles.tobytes() for mesh in meshes}), 1)
        self.assertEqual(len(meshes), 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
