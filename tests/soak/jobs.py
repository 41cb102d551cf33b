"""Mutated job files, planned and run on a tiny cloud.

Right is: status 0, 2, 3 or 4 in bounded time; a message of status 2 that names the job file; inputs and job file as
they were; nothing new on disk where the job did not succeed, but the work directory of one that ran out of a resource.
Where this is root, the program runs as nobody, whatever paths a mutation makes up.
"""
import pathlib
import random
import re

import clouds
import trial
from mutations import mutated

SHORT, LONG = 120, 6000
UNIT = "job files"
JOB = """[input]
files = ["scan.ply"]
[partition]
memory = "256MiB"
chunk_points = 50
[output]
mesh = "mesh.ply"
report = "mesh.report.json"
[run]
threads = 2
"""
VALUES = ["0", "-1", "1", "9223372036854775807", "9223372036854775808", "nan", "inf", "-inf", "1e308", "1e-308", "true",
          "[]", "[[]]", "{}", '""', '"auto"', '"0"', "'a'", '"1GiB"', '"-1GiB"', '"1e300TiB"', "[1, 2, 3]", "[0, 0, 0]",
          '["a", 1]', "2020-01-01", "07", "0x10", '"""a\nb"""', "[0.3, 0.1]", "[nan]", '"\\u0000"', '"\\uD800"', '"ü"',
          "1_000", "\x00", '"' + "x" * 300 + '"', "[" * 200 + "]" * 200]
PATHS = ["", ".", "..", "/", "scan.ply", "./scan.ply", "job.toml", "sub/scan.ply", "missing/out.ply", "*", "[",
         "**/*.ply", "~/scan.ply", "mesh.ply/x.ply", "/dev/null", "/dev/full", "/proc/self/mem", "mesh.report.json",
         "-", "a" * 300 + ".ply", "\\u0000.ply", "mesh\\n.ply", "sub", "sub/", "scan.ply\\u202e", "mesh.foo", ".ply",
         "link.ply", "loop.ply"]
NAMED = re.compile(r"job\.toml|no file matches|\b(?:input|partition|cleaning|normals|reconstruct|fill|output|run)\.\w")
SECTIONS = ["input", "partition", "cleaning", "normals", "reconstruct", "fill", "output", "run"]


def prepare(setup):
    """The job files that mutations begin with, and the user to run as."""
    here = pathlib.Path(__file__).parents[2]
    found = sorted([*here.glob("configs/*.toml"), *here.glob("tests/fuzz/seeds/fuzz_job_file/*.toml")])
    (setup.shared / "scan.ply").write_bytes(clouds.ply(clouds.sphere(150, random.Random(1))))
    texts = [JOB.encode()] * len(found) + [on_tiny_cloud(path.read_bytes()) for path in found]
    return texts, trial.let_nobody_run(setup)


def on_tiny_cloud(text):
    text = re.sub(rb"(?m)^poses *=.*$", b"", text)
    return re.sub(rb"(?ms)^files *= *\[.*?\]", b'files = ["scan.ply"]', text)


def attack(case):
    rng, (texts, user) = case.rng, case.setup.prepared
    lay_out(case)
    text = job_file(rng, texts)
    (case.directory / "job.toml").write_bytes(text)
    before = trial.contents(case.directory)
    arguments = ["plan", "job.toml"] if rng.random() < 0.5 else ["run", "job.toml", "--progress", "none"]
    if rng.random() < 0.2:
        key = rng.choice(["output.mesh", "output.report", "input.files", "partition.memory", "run.work_dir",
                          "run.threads"])
        arguments += ["--set", f"{key}={rng.choice(VALUES + PATHS[:20])}".replace("\x00", "")]
    ended = case.run(arguments, user=user)
    case.counts["job files"] += 1
    case.counts[f"status {ended.status}"] += 1
    right = case.check_ending(ended, {0, 2, 3, 4})
    if right and ended.status == 2 and "--set" not in arguments and not named(ended.error, text.decode(errors="replace")):
        case.wrong("a message that names the job file, the key or the path", ended.shown(), ended.command())
    check_disk(case, ended, before, kept=b"keep_work_dir" in text)


def named(error, job):
    """Whether the message says where in the job the mistake lies: line, key, or a value that is written there."""
    subject = error.removeprefix("orbweave: error: ").split(": ")[0]
    return NAMED.search(error) or subject in job or subject in PATHS or as_written(subject) in as_meant(job)


def as_meant(job):
    """The job's text with its \\u202e and \\n as the characters that they stand for."""
    short = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", '"': '"', "\\": "\\"}
    return re.sub(r"\\(?:u([0-9a-fA-F]{4})|([btnfr\"\\]))",
                  lambda found: chr(int(found[1], 16)) if found[1] else short[found[2]], job)


def as_written(shown):
    """The bytes that a message shows as \\xe2\\x80\\xae."""
    shown_bytes = re.sub(rb"\\x([0-9a-f]{2})", lambda found: bytes.fromhex(found[1].decode()), shown.encode())
    return shown_bytes.decode(errors="replace")


def lay_out(case):
    """The cloud, a folder and links, where the program may write."""
    data = (case.setup.shared / "scan.ply").read_bytes()
    (case.directory / "sub").mkdir()
    for name in ("scan.ply", "sub/scan.ply"):
        (case.directory / name).write_bytes(data)
    (case.directory / "link.ply").symlink_to("scan.ply")
    (case.directory / "loop.ply").symlink_to("loop.ply")
    for path in (case.directory, case.directory / "sub"):
        path.chmod(0o777)


def job_file(rng, seeds):
    text = rng.choice(seeds)
    for _ in range(rng.choice([1, 1, 1, 2])):
        how = rng.choice([other_value, other_value, other_path, other_path, other_key, other_line, mutated])
        text = how(text, rng)
    return text


def _lines_with_values(text):
    lines = text.split(b"\n")
    return lines, [k for k, line in enumerate(lines) if b"=" in line and not line.lstrip().startswith(b"#")]


def other_value(text, rng):
    lines, at = _lines_with_values(text)
    if at:
        k = rng.choice(at)
        lines[k] = lines[k].split(b"=")[0] + b"= " + rng.choice(VALUES).encode(errors="surrogatepass")
    return b"\n".join(lines)


def other_path(text, rng):
    """In a key that is a path, there already or not."""
    key = rng.choice(["mesh", "report", "picture", "work_dir", "files", "poses"])
    path = rng.choice(PATHS)
    value = f'["{path}"]' if key == "files" else f'"{path}"'
    lines, at = _lines_with_values(text)
    for k in at:
        if lines[k].split(b"=")[0].strip() == key.encode():
            lines[k] = f"{key} = {value}".encode()
            return b"\n".join(lines)
    section = {"files": "input", "poses": "input", "work_dir": "run"}.get(key, "output")
    return text.replace(f"[{section}]".encode(), f"[{section}]\n{key} = {value}".encode(), 1)


def other_key(text, rng):
    lines, at = _lines_with_values(text)
    if at:
        k = rng.choice(at)
        key, _, value = lines[k].partition(b"=")
        name = bytearray(key.strip())
        if name:
            name[rng.randrange(len(name))] = rng.choice(b"abcxyz_-. \"'\xc3\xff")
        lines[k] = bytes(name) + b" =" + value
    return b"\n".join(lines)


def other_line(text, rng):
    """A line doubled, dropped, moved, or another section's head."""
    lines = text.split(b"\n")
    line = lines.pop(rng.randrange(len(lines)))
    for _ in range(rng.choice([0, 1, 1, 2])):
        lines.insert(rng.randrange(len(lines) + 1), line)
    if rng.random() < 0.3:
        lines.insert(rng.randrange(len(lines) + 1), f"[{rng.choice(SECTIONS)}]".encode())
    return b"\n".join(lines)


def check_disk(case, ended, before, kept):
    """sub/scan.ply may be an output that is there already; a work directory stays where the job says so, and where
    the radii that were given do not suit the points, for others."""
    after = trial.contents(case.directory)
    touched = sorted(name for name in before if after.get(name) != before[name])
    if touched and (ended.status != 0 or touched != ["sub/scan.ply"]):
        case.wrong("inputs and job file as they were", f"changed or gone: {touched}", ended.command())
    new = sorted(name for name in after if name not in before)
    store = all((case.directory / name.split("/")[0] / "orbweave-store.json").exists() for name in new)
    resumable = store and (kept or "radi" in ended.error)
    if new and ended.status in (2, 3) and not resumable:
        case.wrong(f"nothing new after status {ended.status}", f"{new[:5]}: {ended.error}", ended.command())
    if new and ended.words[1] == "plan":
        case.wrong("a plan that writes nothing", f"{new[:5]}", ended.command())
