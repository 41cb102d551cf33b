"""Clouds that break plans, with and without a stray point, larger than those whose bytes are compared.

Right is: status 0 or 3 in bounded time and within the budget, and the same status with the stray as without it, in two
cuts the same bytes.
"""
import clouds
import trial

SHORT, LONG = 14, 700
UNIT = "hostile clouds"
BUDGET = 256


def prepare(setup):
    return None


def attack(case):
    rng, kinds = case.rng, sorted(clouds.KINDS)
    kind = kinds[case.number % len(kinds)]
    points = clouds.KINDS[kind](int(10 ** rng.uniform(2, 3.6)), rng)
    if rng.random() < 0.3:
        points = clouds.moved(points, 10.0 ** rng.randint(-6, 6), (5e5, 5e6, 100.0))
    stray = rng.choice(clouds.STRAYS)
    chunk = rng.choice(["100", "1000"])
    case.counts["hostile clouds"] += 1
    case.counts[kind] += 1
    (case.directory / "scan.ply").write_bytes(clouds.ply(points))
    plain = reconstructed(case, "scan.ply", "auto")
    (case.directory / "stray.ply").write_bytes(clouds.ply([*points, (*stray, *clouds.UP)]))
    whole, cut = (reconstructed(case, "stray.ply", size) for size in ("auto", chunk))
    if case.problems:
        return
    if whole.status != plain.status:
        case.wrong(f"the status without the stray {stray}: {plain.shown()}", whole.shown(), whole.command())
    if (whole.status, whole.mesh) != (cut.status, cut.mesh):
        case.wrong(f"the mesh of one chunk: {whole.shown()}", cut.shown(), cut.command())


def reconstructed(case, name, chunk_points):
    ended = case.run(["reconstruct", name, "-o", "out.ply", "--chunk-points", chunk_points, "--memory",
                      f"{BUDGET}MiB", "--threads", "2", "--progress", "none"])
    case.check_ending(ended, {0, 3}, BUDGET * trial.MEBIBYTE)
    mesh = case.directory / "out.ply"
    ended.mesh = trial.digest(mesh) if mesh.exists() else None
    mesh.unlink(missing_ok=True)
    return ended
