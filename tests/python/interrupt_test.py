"""Callbacks, Ctrl-C and other threads of Python while the library works."""
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
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


class AtTheEnd(unittest.TestCase):
    """The interpreter ends while another thread is in the library: no thread crashes, none is waited for."""

    def ended(self, code):
        done = subprocess.run([sys.executable, "-c", textwrap.dedent(code), os.path.dirname(os.path.abspath(__file__))],
                              capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_threads_that_do_not_hold_up_the_end_stop(self):
        for seconds in (0.0, 0.1, 0.4):
            self.assertEqual(self.ended(f"""
                import sys, threading, time
                sys.path.insert(0, sys.argv[1])
                import orbweave
                from support import sphere
                points = sphere(300000)
                def work():
                    orbweave.reconstruct(points)
                    print("all of it was done")
                threading.Thread(target=work, daemon=True).start()
                time.sleep({seconds})
                """), "")

    def test_writing_comes_to_its_end(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cloud.csv")
            self.ended(f"""
                import sys, threading
                sys.path.insert(0, sys.argv[1])
                import orbweave
                from support import sphere
                cloud = orbweave.PointCloud(sphere(300000))
                threading.Thread(target=lambda: orbweave.write_points({path!r}, cloud), daemon=True).start()
                """)
            self.assertEqual(os.listdir(folder), ["cloud.csv"])
            self.assertEqual(len(orbweave.read_points(path)), 300000)

    def test_a_callback_that_does_not_return_is_not_waited_for(self):
        self.ended("""
            import sys, threading, time
            sys.path.insert(0, sys.argv[1])
            import orbweave
            from support import sphere
            called = threading.Event()
            def progress(stage, done):
                called.set()
                time.sleep(100)
            threading.Thread(target=lambda: orbweave.reconstruct(sphere(300000), progress=progress), daemon=True).start()
            called.wait()
            """)

    def test_what_the_end_itself_calls_is_done(self):
        self.assertEqual(self.ended("""
            import atexit, sys
            sys.path.insert(0, sys.argv[1])
            atexit.register(lambda: print(len(orbweave.reconstruct(sphere(800)).vertices)))
            import orbweave
            from support import sphere
            """), "800\n")

    def test_a_child_does_not_wait_for_threads_of_its_parent(self):
        self.assertEqual(self.ended("""
            import os, sys, threading, time
            sys.path.insert(0, sys.argv[1])
            import orbweave
            from support import sphere
            thread = threading.Thread(target=lambda: orbweave.reconstruct(sphere(200000)))
            thread.start()
            time.sleep(0.2)
            child = os.fork()
            if child != 0:
                print(os.waitpid(child, 0)[1])
            """), "0\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
