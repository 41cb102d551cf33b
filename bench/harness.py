"""What the benchmark scripts share: running programs with time and memory measured, medians, the machine,
JSON and CSV results. Needs Debian's time."""
import csv
import datetime
import json
import math
import os
import pathlib
import platform
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import interpreter

ROOT = pathlib.Path(__file__).resolve().parent.parent
PEERS = ROOT / "bench" / "peers"
# Square world units of the generated shapes: radii 1 and 0.4 of the torus, unit squares, unit cube.
AREAS = {"sphere": 4 * math.pi, "torus": 4 * math.pi ** 2 * 0.4, "plane": 1.0, "double-wall": 2.0,
         "cube": 6.0}


def peer_python():
    """The interpreter that Open3D is installed for."""
    return interpreter.with_packages("open3d") or sys.exit("no Python here has open3d: install python3-open3d")


def run(command):
    """Runs to the end under /usr/bin/time. Returns wall, user and system seconds, peak memory, standard
    output. Ends the script, with the program's own words, where the program fails."""
    with tempfile.NamedTemporaryFile("r", suffix=".time") as measured:
        words = ["/usr/bin/time", "-q", "-f", "%e %U %S %M", "-o", measured.name]
        status, output, errors = _finished(words + [str(word) for word in command])
        if status != 0:
            shown = " ".join(str(word) for word in command)
            sys.exit(f"exit status {status} from: {shown}\n{errors[-2000:]}")
        wall, user, system, peak_kib = measured.read().split()[-4:]
    return {"wall_seconds": float(wall), "user_seconds": float(user), "system_seconds": float(system),
            "peak_memory_bytes": int(peak_kib) * 1024, "stdout": output}


def _finished(words):
    """Exit status, standard output and error. Where the script is interrupted, so is all that runs for it."""
    with subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          start_new_session=True) as process:
        try:
            output, errors = process.communicate()
        except BaseException:
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            _wait_for_group(process.pid)
            raise
        return process.returncode, output, errors


def _wait_for_group(group, seconds=60.0):
    """`time` ends at once, what it started when it has cleaned up."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    os.killpg(group, signal.SIGKILL)


def run_within(command, cpu_seconds, memory_bytes):
    """As run(), at the lowest priority and with limits on processor time and resident memory: wall time would say how busy
    the machine is. At three times the limit of wall time a program is stopped all the same. A program that was stopped
    has {"stopped": reason} and what was measured until then."""
    words = ["nice", "-n", "19", *(str(word) for word in command)]
    begin = time.monotonic()
    usage, reason = {"peak_memory_bytes": 0, "cpu_seconds": 0.0}, None
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        with subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=output, stderr=errors,
                              start_new_session=True) as process:
            try:
                while process.poll() is None and reason is None:
                    time.sleep(0.2)
                    usage = _usage(process.pid) or usage
                    if usage["cpu_seconds"] > cpu_seconds or time.monotonic() - begin > 3 * cpu_seconds:
                        reason = f"not ended in {usage['cpu_seconds']:.0f} CPU s"
                    elif usage["peak_memory_bytes"] > memory_bytes:
                        reason = f"more than {memory_bytes / 2**30:.0f} GiB after {usage['cpu_seconds']:.0f} CPU s"
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
        measured = {"wall_seconds": time.monotonic() - begin, **usage}
        if reason:
            return {"stopped": reason, **measured}
        output.seek(0)
        errors.seek(0)
        if process.returncode != 0:
            sys.exit(f"exit status {process.returncode} from: {' '.join(words)}\n{errors.read()[-2000:]}")
        return {**measured, "stdout": output.read()}


def _usage(pid):
    """Peak of resident memory and processor seconds of a process so far; none where it has ended."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
        times = pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except OSError:
        return None
    peak = re.search(r"^VmHWM:\s*(\d+) kB", status, re.M)
    if not peak:
        return None
    return {"peak_memory_bytes": int(peak.group(1)) * 1024,
            "cpu_seconds": (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")}


def spread(samples):
    """Median, extremes and the half range relative to the median."""
    middle = statistics.median(samples)
    half = (max(samples) - min(samples)) / 2
    return {"samples": samples, "median": middle, "min": min(samples), "max": max(samples),
            "relative_half_range": half / middle if middle else 0.0}


def alternate(runs, repeats):
    """{name: callable} -> {name: [results]}; one of each in turn, so that a busy minute hits all."""
    results = {name: [] for name in runs}
    for _ in range(repeats):
        for name, call in runs.items():
            results[name].append(call())
    return results


def machine():
    facts = {"system": platform.platform(), "cores": os.cpu_count(), "processor": "unknown"}
    cpu = pathlib.Path("/proc/cpuinfo")
    if cpu.exists():
        names = re.findall(r"^model name\s*: (.*)$", cpu.read_text(), re.M)
        facts["processor"] = names[0] if names else "unknown"
    memory = pathlib.Path("/proc/meminfo")
    if memory.exists():
        kib = re.search(r"^MemTotal:\s*(\d+)", memory.read_text(), re.M)
        facts["memory_bytes"] = int(kib.group(1)) * 1024 if kib else None
    facts["load_at_start"] = os.getloadavg()[0]
    return facts


def commit():
    words = ["git", "-C", str(ROOT), "describe", "--always", "--dirty"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def add_common_options(parser):
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/orbweave"))
    parser.add_argument("--out", default=str(ROOT / "build/bench"), help="directory of the results")
    parser.add_argument("--work", default=str(ROOT / "build/bench/work"),
                        help="directory for clouds and meshes; clouds newer than the program are reused")


def prepare(options):
    """Makes the directories; ends the script where the program is missing."""
    if not os.access(options.program, os.X_OK):
        sys.exit(f"no program {options.program}: ./dev build")
    for folder in (options.out, options.work):
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    for doubt in doubts(options.program):
        print(f"warning: {doubt}", file=sys.stderr)
    return pathlib.Path(options.work)


def doubts(program):
    """Why seconds that are measured now would mislead."""
    cache = pathlib.Path(program).resolve().parent.parent / "CMakeCache.txt"
    if cache.exists():
        build = re.search(r"^CMAKE_BUILD_TYPE:\w+=(.*)$", cache.read_text(encoding="utf-8"), re.M)
        if build and build.group(1) != "Release":
            yield f"{program} is a build of type {build.group(1) or 'none'}: its seconds are not those of a release"
    load = os.getloadavg()[0]
    if load > 0.25 * os.cpu_count():
        yield f"the machine is busy (load {load:.1f} of {os.cpu_count()} cores): seconds are too long"


def program_version(program):
    return run([program, "--version"])["stdout"].strip()


def made(path, command):
    """`path`, after running `command` (the program, writing it) where it is missing or older than the
    program."""
    program = pathlib.Path(command[0])
    if not path.exists() or path.stat().st_mtime < program.stat().st_mtime:
        run(command)
    return path


def oriented(program, work, mesh):
    """The cloud of a mesh's vertices with normals from its faces."""
    cloud = work / (mesh.name.split(".")[0] + ".oriented.ply")
    return made(cloud, [program, "convert", "--normals-from-faces", mesh, cloud])


def generated(program, work, shape, points, noise=0.0):
    cloud = work / f"{shape}-{points}-noise{noise:g}.ply"
    words = [program, "generate", shape, "--points", points, "-o", cloud]
    return made(cloud, words + (["--noise", f"{noise:g}"] if noise else []))


def spacing(shape, points):
    """sqrt(area / points), the unit of the generated clouds' noise."""
    return math.sqrt(AREAS[shape] / points)


def reconstruct(program, cloud, mesh, arguments=(), launcher=()):
    """A whole job; the report's content is in "report". launcher: what starts the program, mpirun with its options."""
    clouds = cloud if isinstance(cloud, (list, tuple)) else [cloud]
    return _job([*launcher, program, "reconstruct", *clouds, "-o", mesh, "--report", _report(mesh), "--work-dir",
                 _work(mesh), "--progress", "none", *arguments], mesh)


def run_job(program, job_file, clouds, mesh, settings=()):
    """The same for a job file, with other clouds and another mesh; settings: section.key=value."""
    own = {"input.files": json.dumps([str(pathlib.Path(cloud).resolve()) for cloud in clouds]),
           "output.mesh": mesh, "output.report": _report(mesh), "output.picture": "", "run.work_dir": _work(mesh)}
    words = [f"{key}={value}" for key, value in own.items()] + list(settings)
    return _job([program, "run", job_file, "--progress", "none"] +
                [word for setting in words for word in ("--set", setting)], mesh)


def _report(mesh):
    return pathlib.Path(str(mesh) + ".report.json")


def _work(mesh):
    return pathlib.Path(str(mesh) + ".work")


def _job(words, mesh):
    shutil.rmtree(_work(mesh), ignore_errors=True)
    measured = run(words)
    measured["report"] = json.loads(_report(mesh).read_text(encoding="utf-8"))
    return measured


def stages(report):
    """{stage: facts}, whether the report lists them or keys them by name."""
    listed = report["stages"]
    return {s["name"]: s for s in listed} if isinstance(listed, list) else listed


def table(rows, columns):
    """Aligned text of dictionaries."""
    def show(value):
        if isinstance(value, float):
            return f"{value:.4g}"
        return f"{value:,}" if isinstance(value, int) and not isinstance(value, bool) else str(value)

    cells = [columns] + [[show(row.get(name, "")) for name in columns] for row in rows]
    widths = [max(len(line[c]) for line in cells) for c in range(len(columns))]
    return "\n".join("  ".join(text.ljust(w) if c == 0 else text.rjust(w)
                               for c, (text, w) in enumerate(zip(line, widths))) for line in cells)


def exit_status(missed):
    """Prints the targets that were missed; 1 where there are any."""
    for miss in missed:
        print(f"missed: {miss}")
    return 1 if missed else 0


def write_results(options, name, rows, extra=None):
    """<out>/<name>.json with machine and versions, <out>/<name>.csv with the rows' plain values."""
    out = pathlib.Path(options.out)
    document = {"benchmark": name, "machine": machine(), "commit": commit(),
                "program": program_version(options.program), "arguments": sys.argv[1:],
                "finished": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
                "rows": rows, **(extra or {})}
    (out / f"{name}.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    columns = list(dict.fromkeys(key for row in rows for key, value in row.items()
                                 if not isinstance(value, (dict, list))))
    with open(out / f"{name}.csv", "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)
    print(f"\nresults: {out / name}.json and .csv")
