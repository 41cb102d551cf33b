#!/usr/bin/python3
"""Sends a signal to the program at random moments of every stage and measures how long it takes to end.

The clouds are those that make stages long: a patch a halo wide with 30% of the points, a dense spot, a fractal, layers,
raw points whose normals are estimated and propagated after a clean-up, a large torus; and the commands that make no job:
convert, generate, fill, inspect, compare. One huge chunk and one thread make what happens between two chunks rare.

A first run of each job, undisturbed or ended after --longest seconds, tells when its stages begin. Then every stage of it
gets --signals signals, SIGTERM and SIGINT in turn, at moments drawn from the seed. The stage that counts is the one that
the program said it was in when the signal came. After each: the status is 130 (or 0, where the job ended before) and
no temporary of an output is left.

The exit status is 1 when a program took longer than --patience seconds, or anything else does not hold.

usage: tests/soak/stop_latency.py [--program FILE] [--signals 3] [--seed 1] [--small] [--only NAME,...] [--json FILE]
"""
import argparse
import json
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# One chunk, whatever the cloud; the budget is large enough that none is cut because of it.
ONE_CHUNK = ["--memory", "4GiB", "--chunk-points", "100000000", "--threads", "1", "--progress", "plain", "-o", "mesh.ply"]
RAW = ["--normals", "estimate", "--orientation", "propagate", "--outlier-sigma", "6"]


class Clouds:
    """Makes inputs once, in a folder of their own."""

    def __init__(self, program, folder, small):
        self.program, self.folder, self.scale = program, folder, 0.1 if small else 1.0

    def points(self, count):
        return max(2000, int(count * self.scale))

    def write(self, name, count, kind):
        path = self.folder / name
        if not path.exists():
            rnd = random.Random(7)
            with open(path, "w", encoding="ascii") as out:
                for point in KINDS[kind](self.points(count), rnd):
                    out.write(" ".join(f"{value:.9g}" for value in point) + "\n")
        return str(path)

    def generated(self, name, count, *more):
        path = self.folder / name
        if not path.exists():
            subprocess.run([self.program, "generate", "bumpy-torus", "--points", str(self.points(count)), "-o", path,
                            *more], check=True, stdout=subprocess.DEVNULL)
        return str(path)

    def bare(self, name, count):
        """Without normals."""
        path = self.folder / name
        if not path.exists():
            csv = self.folder / (name + ".full.csv")
            subprocess.run([self.program, "convert", self.generated(name + ".ply", count, "--noise", "0.3"), csv],
                           check=True, stdout=subprocess.DEVNULL)
            with open(csv, encoding="ascii") as rows, open(path, "w", encoding="ascii") as out:
                for row in rows:
                    out.write(",".join(row.rstrip("\n").split(",")[:3]) + "\n")
            csv.unlink()
        return str(path)


def on_sphere(rnd):
    while True:
        point = [rnd.gauss(0, 1) for _ in range(3)]
        length = sum(value * value for value in point) ** 0.5
        if length > 1e-3:
            return [value / length for value in point]


def patch(count, rnd, sigma=0.01):
    for i in range(count):
        if i % 10 < 7:
            point = on_sphere(rnd)
        else:
            a, b = rnd.gauss(0, sigma), rnd.gauss(0, sigma)
            length = (1 + a * a + b * b) ** 0.5
            point = [1 / length, a / length, b / length]
        yield (*point, *point)


def fractal(count, rnd):
    corners = [(0, 0, 0), (1, 0, 0), (.5, .866, 0), (.5, .289, .816)]
    at = [0.3, 0.3, 0.3]
    for _ in range(count):
        at = [(value + corner) / 2 for value, corner in zip(at, rnd.choice(corners))]
        yield (*at, 0, 0, 1)


def layers(count, rnd):
    side = max(2, int((count / 20) ** 0.5))
    for z in range(20):
        for x in range(side):
            for y in range(side):
                yield (x + 0.1 * rnd.random(), y + 0.1 * rnd.random(), 0.05 * z, 0, 0, 1 if z % 2 else -1)


KINDS = {"patch": patch, "spot": lambda count, rnd: patch(count, rnd, 0.001), "fractal": fractal, "layers": layers}


def jobs_of(clouds):
    """Name and arguments; made when they are asked for."""
    spacing = 6.0 / clouds.points(300_000) ** 0.5
    raw = lambda: clouds.bare("raw.csv", 300_000)
    dense = lambda name: clouds.write(name + ".xyz", 80_000, name)
    torus = lambda: clouds.generated("torus.ply", 2_000_000)
    return {
        "patch": lambda: ["reconstruct", dense("patch"), *ONE_CHUNK],
        "spot": lambda: ["reconstruct", dense("spot"), *ONE_CHUNK],
        "fractal": lambda: ["reconstruct", dense("fractal"), *ONE_CHUNK],
        "layers": lambda: ["reconstruct", dense("layers"), *ONE_CHUNK],
        "torus": lambda: ["reconstruct", torus(), *ONE_CHUNK, "--picture", "mesh.png", "--report", "mesh.json"],
        "tiles": lambda: ["reconstruct", torus(), *ONE_CHUNK, "--tiles"],
        "raw": lambda: ["reconstruct", raw(), *ONE_CHUNK, *RAW],
        "cleaned": lambda: ["reconstruct", raw(), *ONE_CHUNK, *RAW, "--merge-tolerance", f"{0.5 * spacing:.9g}",
                            "--smooth-radius", f"{8 * spacing:.9g}", "--thin-to-spacing", f"{spacing:.9g}"],
        "convert": lambda: ["convert", torus(), "cloud.csv"],
        "generate": lambda: ["generate", "bumpy-torus", "--points", str(clouds.points(20_000_000)), "-o", "cloud.ply"],
        "inspect": lambda: ["inspect", torus()],
        "compare": lambda: ["compare", truth(clouds), truth(clouds)],
        "fill": lambda: ["fill", truth(clouds), "-o", "filled.ply"],
    }


def truth(clouds):
    clouds.generated("small.ply", 1_000_000, "--truth", str(clouds.folder / "truth.ply"))
    return str(clouds.folder / "truth.ply")


def listen():
    """What a shell starts in the background ignores SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


class Run:
    """A program under way, and the stage that it says it is in."""

    def __init__(self, program, arguments, folder):
        self.begin = time.monotonic()
        self.stages = [("start", 0.0)]
        self.lines = []
        self.process = subprocess.Popen([program, *arguments], cwd=folder, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.PIPE, text=True, preexec_fn=listen)
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stderr:
            self.lines.append(line.rstrip())
            if ": begins" in line:
                self.stages.append((line.split(": begins")[0], time.monotonic() - self.begin))

    def stage(self):
        return self.stages[-1][0]

    def end(self, number):
        """Sends a signal; returns the seconds until the end."""
        sent = time.monotonic()
        self.process.send_signal(number)
        self.process.wait()
        took = time.monotonic() - sent
        self.reader.join()
        return took


def schedule(run, longest):
    """Stages with when they begin and end, in seconds."""
    try:
        run.process.wait(longest)
    except subprocess.TimeoutExpired:
        run.process.kill()
        run.process.wait()
    end = time.monotonic() - run.begin
    run.reader.join()
    begins = [at for _, at in run.stages[1:]] + [end]
    return [(name, at, max(at, until)) for (name, at), until in zip(run.stages, begins)]


def complaint(run, took, folder, patience):
    status = run.process.returncode
    # Outputs are there whole or not at all; the mesh may be whole while the picture is drawn.
    left = [path.name for path in folder.iterdir() if path.name.endswith(".part")]
    if took > patience:
        return f"ended after {took:.2f} s"
    if status not in (0, 130, -signal.SIGTERM, -signal.SIGINT) or (status < 0 and run.stage() != "start"):
        return f"status {status}: {run.lines[-1:]}"
    if left:
        return f"left {left}"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/orbweave"))
    parser.add_argument("--signals", type=int, default=3, help="per stage of every job")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=2.0)
    parser.add_argument("--longest", type=float, default=60.0)
    parser.add_argument("--small", action="store_true", help="clouds of a tenth of the size")
    parser.add_argument("--only", default="", help="names of jobs")
    parser.add_argument("--json", default="")
    options = parser.parse_args()
    rnd = random.Random(options.seed)
    program = str(pathlib.Path(options.program).resolve())
    worst, wrong, signals = {}, [], 0
    with tempfile.TemporaryDirectory() as place:
        clouds_folder, folder = pathlib.Path(place, "clouds"), pathlib.Path(place, "run")
        clouds_folder.mkdir()
        for name, make in jobs_of(Clouds(program, clouds_folder, options.small)).items():
            if options.only and name not in options.only.split(","):
                continue
            arguments = make()
            fresh(folder)
            for stage, begins, ends in schedule(Run(program, arguments, folder), options.longest):
                for i in range(options.signals):
                    fresh(folder)
                    run = Run(program, arguments, folder)
                    time.sleep(begins + (ends - begins) * rnd.random())
                    stage = run.stage()
                    took = run.end((signal.SIGTERM, signal.SIGINT)[i % 2])
                    signals += 1
                    worst[name, stage] = max(worst.get((name, stage), 0.0), took)
                    print(f"{name}, {stage}: {took:.3f} s, status {run.process.returncode}", flush=True)
                    problem = complaint(run, took, folder, options.patience)
                    if problem:
                        wrong.append(f"{name}, {stage}: {problem}")
                        print("WRONG", wrong[-1], flush=True)
    report(worst, wrong, signals, options)
    return 1 if wrong else 0


def fresh(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()


def report(worst, wrong, signals, options):
    for (name, stage), took in sorted(worst.items(), key=lambda item: -item[1]):
        print(f"{took:7.3f} s  {name}, {stage}")
    print(f"{signals} signals, {len(worst)} stages, {len(wrong)} wrong, slowest {max(worst.values(), default=0.0):.3f} s")
    if options.json:
        rows = [{"job": name, "stage": stage, "seconds": took} for (name, stage), took in worst.items()]
        pathlib.Path(options.json).write_text(json.dumps({"signals": signals, "wrong": wrong, "worst": rows}, indent=1))


if __name__ == "__main__":
    sys.exit(main())
