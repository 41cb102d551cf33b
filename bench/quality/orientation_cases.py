#!/usr/bin/env python3
"""Whether normals' sides are right where no scanner's place is known, and whether the run says so where they are not.

Simulated clouds with known sides (orientation_scenes.py, `orbweave generate`): interiors, terrain with trees, thin
walls, rooms joined by a door, closed objects, open sheets. Each is meshed without patches; *right* is the share of the
mesh's area that faces the side of the truth at the nearest points of the cloud. A case is wrong below 0.99. The exit
status is 1 where a case is wrong without a warning; warnings of cases that are right are counted.

usage: bench/quality/orientation_cases.py [--only NAME] [--data DATA_DIR]
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import interpreter  # noqa: E402

interpreter.need("numpy", "scipy")

import harness  # noqa: E402
import numpy as np  # noqa: E402
import orientation_scenes as scenes  # noqa: E402
from meshes import read_mesh, read_ply, write_cloud  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

RIGHT = 0.99
WARNING = "the side of the normals is"
JOBS = {"auto": "configs/object.toml", "ground": "configs/terrestrial-scan.toml"}
COLUMNS = ["case", "rule", "points", "right", "warned", "patches", "contested", "contested_area", "doubtful_area",
           "components", "interiors", "verdict"]

# name: (cloud, rules)
CASES = {
    "empty room, 1 tripod": (scenes.empty_room, ["auto"]),
    "empty room, 2 tripods": (lambda: scenes.empty_room(tripods=2), ["auto", "ground"]),
    "empty room, even": (lambda: scenes.evened(scenes.empty_room(400_000, 2), 0.04), ["auto", "ground"]),
    "furnished room": (scenes.furnished_room, ["auto", "ground"]),
    "furnished room, even": (lambda: scenes.evened(scenes.furnished_room(400_000), 0.03), ["auto", "ground"]),
    "two rooms and a door": (scenes.two_rooms, ["auto", "ground"]),
    "two rooms and a door, even": (lambda: scenes.evened(scenes.two_rooms(400_000), 0.04), ["auto", "ground"]),
    "room without a ceiling": (scenes.room_without_ceiling, ["auto", "ground"]),
    "room with a partition": (scenes.room_with_partition, ["auto", "ground"]),
    "corridor": (scenes.corridor, ["auto", "ground"]),
    "tunnel, even": (scenes.tunnel, ["auto", "ground"]),
    "cave, even": (scenes.cave, ["auto", "ground"]),
    "ball in a room": (scenes.ball_in_room, ["auto", "ground"]),
    "balls on a floor": (scenes.balls_on_a_floor, ["auto", "ground"]),
    "mug on a table": (scenes.mug_on_a_table, ["auto", "ground"]),
    "courtyard": (scenes.courtyard, ["auto", "ground"]),
    "facade": (scenes.facade, ["auto", "ground"]),
    "block on the ground": (scenes.house_from_around, ["auto", "ground"]),
    "block seen close from six sides": (scenes.block_from_six_sides, ["auto"]),
    "block without a bottom": (scenes.block_from_five_sides, ["auto"]),
    "forest": (scenes.forest, ["auto", "ground"]),
    "forest, airborne": (lambda: scenes.forest(airborne=True), ["auto", "ground"]),
    "hills": (lambda: scenes.forest(trees=1, leafy=False), ["auto", "ground"]),
    "bowl, wall of 3 spacings": (scenes.bowl, ["auto"]),
    "bowl, wall of 1.5 spacings": (lambda: scenes.bowl(1.5), ["auto"]),
    "bowl, wall of 0.7 spacings": (lambda: scenes.bowl(0.7), ["auto"]),
    "deep bowl, wall of 3 spacings": (lambda: scenes.bowl(opening=150.0), ["auto"]),
    "outer side of a bowl": (scenes.shell_of_bowl, ["auto"]),
    "vase, wall of 3 spacings": (scenes.vase, ["auto"]),
    "vase, wall of 6 spacings": (lambda: scenes.vase(6.0), ["auto"]),
    "hollow ball, wall of 4 spacings": (lambda: scenes.hollow_ball(4.0), ["auto"]),
    "hollow ball, wall of 20 spacings": (lambda: scenes.hollow_ball(20.0), ["auto"]),
    "two balls": (scenes.two_balls, ["auto"]),
    "waves": (scenes.waves, ["auto", "ground"]),
    "waves, tilted by 60 degrees": (lambda: scenes.waves(tilt=60.0), ["auto"]),
    "waves, upright": (lambda: scenes.waves(tilt=90.0), ["auto"]),
}
GENERATED = [("sphere", 20_000, 0.0), ("torus", 40_000, 0.0), ("bumpy-torus", 60_000, 0.3), ("cube", 40_000, 0.0),
             ("plane", 20_000, 0.0), ("double-wall", 20_000, 0.0)]
SCENES = [("room", 300_000), ("house", 200_000)]
REAL = ["stanford/bun_zipper.ply", "stanford/dragon_vrip_res3.ply", "stanford/dragon_vrip_res2.ply",
        "points_normals/kitten.xyz", "points_normals/lion_takanawa_normals_rgb.ply"]


def vectors(vertex, names):
    return np.stack([np.asarray(vertex[name], float) for name in names], 1)


def oriented_cloud(path):
    vertex = read_ply(path)["vertex"]
    return scenes.Cloud(vectors(vertex, "xyz"), vectors(vertex, ("nx", "ny", "nz")))


def generated(options, work, shape, points, noise):
    return oriented_cloud(harness.generated(options.program, work, shape, points, noise))


def scene(options, work, name, points):
    """Of the program's own scenes, the truth is the mesh; the clouds' normals are its faces' nearest to the points."""
    cloud, truth = work / f"cases-{name}.ply", work / f"cases-{name}-truth.ply"
    harness.made(cloud, [options.program, "generate", name, "--points", points, "--noise", 0.2, "-o", cloud, "--truth",
                         truth])
    positions = vectors(read_ply(cloud)["vertex"], "xyz")
    samples, normals = sampled(*read_mesh(truth), 6 * len(positions))
    distance, nearest = cKDTree(samples).query(positions)
    known = distance < 0.1  # leaves and persons who walk belong to no surface
    return scenes.Cloud(positions, np.where(known[:, None], normals[nearest], 0.0))


def sampled(positions, triangles, count, seed=1):
    random = np.random.default_rng(seed)
    corners = positions[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    chosen = random.choice(len(triangles), count, p=areas / areas.sum())
    a, b = random.uniform(size=(2, count))
    a, b = np.where(a + b > 1, 1 - a, a), np.where(a + b > 1, 1 - b, b)
    corner = corners[chosen]
    samples = corner[:, 0] + a[:, None] * (corner[:, 1] - corner[:, 0]) + b[:, None] * (corner[:, 2] - corner[:, 0])
    return samples, normals[chosen] / areas[chosen][:, None]


def real(options, work, path):
    if path.suffix == ".xyz":
        rows = np.loadtxt(path)
        return scenes.Cloud(rows[:, :3], rows[:, 3:6])
    if path.parent.name == "stanford":
        return oriented_cloud(harness.oriented(options.program, work, path))
    return oriented_cloud(path)


def cases(options, work):
    """(name, function that makes the cloud, rules)"""
    for name, (make, rules) in CASES.items():
        yield name, make, rules
    for shape, points, noise in GENERATED:
        yield shape, lambda s=shape, p=points, n=noise: generated(options, work, s, p, n), ["auto"]
    for name, points in SCENES:
        yield f"generate {name}", lambda n=name, p=points: scene(options, work, n, p), ["auto", "ground"]
    for name in REAL if options.data else []:
        path = pathlib.Path(options.data) / name
        if path.exists():
            yield path.stem, lambda p=path: real(options, work, p), ["auto"]


def share_right(mesh, cloud):
    """Of the area of the faces whose corners' nearest points have a side."""
    positions, triangles = read_mesh(mesh)
    if len(triangles) == 0:
        return 0.0
    normals = cloud.normals[cKDTree(cloud.positions).query(positions)[1]]
    corners = positions[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    agreement = (faces * normals[triangles].sum(axis=1)).sum(axis=1)
    areas = np.linalg.norm(faces, axis=1)
    judged = agreement != 0.0
    return float(areas[agreement > 0.0].sum() / areas[judged].sum())


def verdict(right, warned):
    if right >= RIGHT:
        return "warned without need" if warned else "ok"
    return "wrong, warned" if warned else "wrong, unsaid"


def measure(options, work, name, cloud, rule):
    stem = "cases-" + "".join(letter if letter.isalnum() else "-" for letter in name)
    points = np.zeros(len(cloud.positions), [(axis, "<f8") for axis in "xyz"])
    for axis, values in zip("xyz", cloud.positions.T):
        points[axis] = values
    path, mesh = work / f"{stem}-in.ply", work / f"{stem}-{rule}-mesh.ply"
    write_cloud(path, points)
    result = harness.run_job(options.program, harness.ROOT / JOBS[rule], [path], mesh,
                             ["normals.source=estimate", f"normals.orientation={rule}", "fill.enabled=false"])
    report = result["report"]
    normals = report["normals"]
    right = share_right(mesh, cloud)
    warned = any(WARNING in text for text in report["warnings"])
    return {"case": name, "rule": rule, "points": len(points), "right": round(right, 4), "warned": warned,
            "patches": normals["patches"], "contested": normals["contested_patches"],
            "components": normals["components"], "contested_area": normals.get("contested_area"), "interiors": normals.get("interior_components"),
            "doubtful_area": normals.get("doubtful_area"), "verdict": verdict(right, warned)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="cases whose name holds this")
    parser.add_argument("--data", help="directory of real scans, for the closed objects among them")
    harness.add_common_options(parser)
    options = parser.parse_args()
    work = harness.prepare(options)
    rows = []
    for name, make, rules in cases(options, work):
        if options.only not in name:
            continue
        cloud = make()
        for rule in rules:
            rows.append(measure(options, work, name, cloud, rule))
            print(f"{name}, {rule}: {rows[-1]['right']:.4f}, {rows[-1]['verdict']}", flush=True)
    print("\n" + harness.table(rows, COLUMNS))
    harness.write_results(options, "orientation_cases", rows)
    counts = {word: sum(row["verdict"] == word for row in rows)
              for word in ("ok", "wrong, warned", "wrong, unsaid", "warned without need")}
    print(", ".join(f"{word}: {count}" for word, count in counts.items()))
    return 1 if counts["wrong, unsaid"] or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
