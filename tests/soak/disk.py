"""A disk that fills up while a job runs.

A job is run once in a directory in memory (tmpfs) to learn the most that it holds there. A trial runs it again; at a
random moment the directory is made so small that only a part of what is still to come fits. Right is: status 4 and a
message that names a file there and the reason, or status 0 where the most was held already; then the directory
is enlarged, and the same command ends with the same bytes, without leftovers.

Needs the right to mount; without it, every trial is counted as skipped.
"""
import json
import math
import subprocess

import small_job
import trial

SHORT, LONG = 6, 200
UNIT = "full disks"
POINTS = 40_000
MOMENTS = {"oriented": ["bin", "sort", "reconstruct", "stitch", "holes", "export"],
           "raw": ["raw bin", "raw sort", "raw_normals", "raw_patches", "bin", "sort", "reconstruct", "export"]}
REASONS = ["No space left", "not enough room"]  # the system's, or that of a check beforehand
PLENTY = 256 * trial.MEBIBYTE


class Room:
    """A directory in memory that can be made smaller and larger."""

    def __init__(self, place):
        self.place = place

    def __enter__(self):
        self.place.mkdir()
        self._mount(f"size={PLENTY}", "-t", "tmpfs", "orbweave-room")
        return self

    def __exit__(self, *_):
        subprocess.run(["umount", str(self.place)], check=True)

    def _mount(self, options, *words, check=True):
        done = subprocess.run(["mount", "-o", options, *words, str(self.place)], check=check, capture_output=True)
        return done.returncode == 0

    def resize(self, size):
        """False where more than that is held meanwhile."""
        return self._mount(f"remount,size={max(size, 4096)}", check=False)

    def used_bytes(self):
        return int(subprocess.run(["df", "--output=used", "-B1", str(self.place)], capture_output=True, text=True,
                                  check=True).stdout.split()[-1])


class Watched:
    """A run in the room whose log is looked at while it goes on."""

    def __init__(self, program, cloud, raw, room):
        radius = 1.3 * math.sqrt(4 * math.pi ** 2 * 0.4 / POINTS)
        self.words = [program, "reconstruct", str(cloud), "-o", str(room.place / "mesh.ply"), "--radii",
                      f"{radius:.6g}", "--memory", "200MiB", "--work-dir", str(room.place / "work"), "--report",
                      str(room.place / "report.json"), "--progress", "none"]
        self.words += ["--normals", "estimate"] if raw else []
        self.room = room

    def run(self, look):
        """Calls look(log's text) until the run ends."""
        with subprocess.Popen(self.words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              env=trial.ENVIRONMENT) as process:
            while process.poll() is None:
                look(small_job.log_text(self.room.place))
                trial.wait_until(lambda: process.poll() is not None, 0.003)
            return trial.Ended(self.words, process.returncode, b"", process.stderr.read(), 0.0, 0, False)


def prepare(setup):
    """Per kind of job: the most that it holds, and its mesh. None where mounting is not allowed."""
    cloud = setup.shared / "cloud.ply"
    trial.succeed([setup.program, "generate", "torus", "--points", str(POINTS), "-o", str(cloud)], setup.shared)
    try:
        return {kind: undisturbed(setup, cloud, kind == "raw") for kind in MOMENTS}
    except (subprocess.CalledProcessError, OSError) as error:
        print(f"SKIPPED: disk: cannot mount here: {error}", flush=True)
        return None


def undisturbed(setup, cloud, raw):
    """(most bytes held, digest of the mesh)"""
    with Room(setup.shared / "room") as room:
        held = [0]
        ended = Watched(setup.program, cloud, raw, room).run(lambda _: held.append(room.used_bytes()))
        if ended.status != 0:
            raise SystemExit(f"{ended.command()}: {ended.shown()}")
        predicted = json.loads((room.place / "report.json").read_text())["predicted"]["disk_bytes"]
        mesh = trial.digest(room.place / "mesh.ply")
    (setup.shared / "room").rmdir()
    return max(*held, predicted), mesh


def attack(case):
    if case.setup.prepared is None:
        case.counts["skipped"] += 1
        return
    kind = case.rng.choice(sorted(MOMENTS))
    most, mesh = case.setup.prepared[kind]
    moment, share = case.rng.choice(MOMENTS[kind]), case.rng.uniform(0.0, 0.9)
    with Room(case.directory / "room") as room:
        job = Watched(case.setup.program, case.setup.shared / "cloud.ply", kind == "raw", room)
        limits = []

        def shrink(log):
            if not limits and f" {moment}: begins" in log:
                used = room.used_bytes()
                limit = used + int(share * max(0, most - used))
                if room.resize(limit):
                    limits.append(limit)

        ended = job.run(shrink)
        case.counts["full disks" if ended.status == 4 else "disks that sufficed"] += 1
        what = f"{ended.command()}, room of {limits} of {most} bytes from {moment} on"
        check_full(case, room, ended, mesh, what)
        room.resize(PLENTY)
        check_enlarged(case, room, job.run(lambda _: None), mesh, what)


def check_full(case, room, ended, mesh, what):
    if ended.status not in (0, 4):
        case.wrong("exit status of [0, 4]", ended.shown(), what)
    elif ended.status == 4 and not (str(room.place) in ended.error and any(r in ended.error for r in REASONS)):
        case.wrong("a message with a file and the system's reason", ended.shown(), what)
    left = [path.name for path in room.place.glob(".*.part")]
    if ended.status == 4 and left:
        case.wrong("no part file beside the outputs", f"{left}", what)
    path = room.place / "mesh.ply"
    if path.exists() and trial.digest(path) != mesh:
        case.wrong("a mesh that is absent or whole", "another mesh", what)


def check_enlarged(case, room, again, mesh, what):
    path = room.place / "mesh.ply"
    if again.status != 0 or not path.exists() or trial.digest(path) != mesh:
        case.wrong("the same bytes once there is room", again.shown(), what)
    if left := sorted({p.name for p in room.place.iterdir()} - {"mesh.ply", "report.json", "report.html"}):
        case.wrong("nothing left but outputs", str(left), what)
