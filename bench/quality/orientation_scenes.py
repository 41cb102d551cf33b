"""Clouds whose normals' sides are known, for bench/quality/orientation_cases.py: rooms, terrain, thin walls, closed
objects and open sheets. A Cloud has positions and, per point, the surface's normal towards the free side: that of the
scanner. Points that belong to no surface (leaves) have a normal of zero and are not judged."""
import dataclasses

import numpy as np

UP = np.array([0.0, 0.0, 1.0])


@dataclasses.dataclass
class Cloud:
    positions: np.ndarray
    normals: np.ndarray

    def __add__(self, other):
        return Cloud(np.concatenate([self.positions, other.positions]), np.concatenate([self.normals, other.normals]))


# Rooms: rectangles, seen from tripods.

def rectangle(corner, u, v):
    return np.array([corner, u, v], float)


def box(low, high):
    """The six sides of a box."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    sides = []
    for axis in range(3):
        u, v = np.zeros(3), np.zeros(3)
        u[(axis + 1) % 3], v[(axis + 2) % 3] = (high - low)[(axis + 1) % 3], (high - low)[(axis + 2) % 3]
        for corner in (low, np.where(np.arange(3) == axis, high, low)):
            sides.append(rectangle(corner, u, v))
    return sides


def holed_wall(corner, along, up, hole):
    """A wall around an opening: (left, bottom, right, top) as shares of both sides."""
    corner, along, up = (np.asarray(vector, float) for vector in (corner, along, up))
    left, bottom, right, top = hole
    parts = [(0, 0, left, 1), (right, 0, 1, 1), (left, top, right, 1), (left, 0, right, bottom)]
    return [rectangle(corner + a * along + b * up, (c - a) * along, (d - b) * up)
            for a, b, c, d in parts if c > a and d > b]


def tripod_scan(rectangles, place, rays, noise, random, nadir=-75.0):
    """What a scanner sees that sweeps equal steps of both angles and stands on its own legs below `nadir` degrees."""
    rows = int(np.sqrt(rays / 2.0))
    elevation = np.radians(np.linspace(nadir, 90.0, rows, endpoint=False))
    azimuth = np.linspace(0.0, 2.0 * np.pi, int(rays / rows), endpoint=False)
    elevation, azimuth = (grid.ravel() for grid in np.meshgrid(elevation, azimuth))
    directions = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                           np.sin(elevation)], 1)
    distances, normals = np.full(len(directions), np.inf), np.zeros_like(directions)
    for corner, u, v in rectangles:
        normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = (corner - place) @ normal / (directions @ normal)
            offset = place + distance[:, None] * directions - corner
            a, b = offset @ u / (u @ u), offset @ v / (v @ v)
            hit = (distance > 1e-6) & (distance < distances) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
        distances[hit] = distance[hit]
        normals[hit] = normal
    seen = np.isfinite(distances) & (distances < 80.0)
    directions, normals = directions[seen], normals[seen]
    normals *= -np.sign((normals * directions).sum(axis=1))[:, None]
    ranges = distances[seen] + noise * random.standard_normal(seen.sum())
    return Cloud(place + ranges[:, None] * directions, normals)


def scanned(rectangles, places, rays, noise=0.002, seed=1, nadir=-75.0):
    random = np.random.default_rng(seed)
    clouds = [tripod_scan(rectangles, np.array(place, float), rays, noise, random, nadir) for place in places]
    return sum(clouds[1:], clouds[0])


def evened(cloud, spacing):
    """At most one point per cube: what thinning leaves of a scan's density."""
    cells = np.floor(cloud.positions / spacing).astype(np.int64)
    _, kept = np.unique(cells, axis=0, return_index=True)
    kept.sort()
    return Cloud(cloud.positions[kept], cloud.normals[kept])


def furniture():
    """A table, a shelf, a lamp that hangs free."""
    parts = box([2.4, 1.6, 0.70], [3.8, 2.4, 0.76])
    for x in (2.45, 3.69):
        for y in (1.65, 2.29):
            parts += box([x, y, 0], [x + 0.06, y + 0.06, 0.7])
    for height in (0.4, 0.9, 1.4):
        parts += box([0.0, 3.2, height], [0.4, 4.6, height + 0.05])
    return parts + box([4.5, 3.5, 1.9], [4.8, 3.8, 2.2])


def empty_room(rays=80_000, tripods=1):
    return scanned(box([0, 0, 0], [6, 5, 2.6]), [[2.5, 2.0, 1.5], [4.6, 3.6, 1.5]][:tripods], rays // tripods)


def furnished_room(rays=160_000):
    return scanned(box([0, 0, 0], [6, 5, 2.6]) + furniture(), [[1.5, 1.2, 1.5], [4.8, 1.6, 1.5], [3.0, 4.2, 1.5]],
                   rays // 3)


def two_rooms(rays=160_000):
    """Behind one another, joined by a doorway 0.9 m wide through a wall 0.12 m thick."""
    door = (0.4, 0.0, 0.58, 0.8)
    walls = []
    for low, high in (((0, 0, 0), (6, 5, 2.6)), ((6.12, 0, 0), (10.5, 5, 2.6))):
        sides = box(low, high)
        walls += sides[2:] + ([sides[0]] if low[0] == 0 else [sides[1]])
    for x in (6.0, 6.12):
        walls += holed_wall([x, 0, 0], [0, 5, 0], [0, 0, 2.6], door)
    for y in (2.0, 2.9):
        walls.append(rectangle([6, y, 0], [0.12, 0, 0], [0, 0, 2.08]))
    walls += [rectangle([6, 2.0, z], [0.12, 0, 0], [0, 0.9, 0]) for z in (0, 2.08)]
    return scanned(walls, [[2.5, 2.0, 1.5], [4.8, 3.5, 1.5], [8.4, 2.4, 1.5]], rays // 3)


def room_without_ceiling(rays=80_000):
    return scanned(box([0, 0, 0], [6, 5, 2.6])[:5], [[2.5, 2.0, 1.5], [4.6, 3.6, 1.5]], rays // 2)


def room_with_partition(rays=160_000):
    """A free-standing wall 0.15 m thick, seen from both sides."""
    walls = box([0, 0, 0], [7, 5, 2.6]) + box([3.4, 1.2, 0], [3.55, 3.8, 1.9])
    return scanned(walls, [[1.6, 2.5, 1.5], [5.4, 2.5, 1.5]], rays // 2)


def corridor(rays=120_000):
    return scanned(box([0, 0, 0], [20, 2, 2.5]), [[3, 1, 1.5], [10, 1, 1.5], [17, 1, 1.5]], rays // 3)


def tunnel(points_along=300, seed=1):
    """Seen from a scanner that moves along: open at both ends, evenly dense."""
    return revolved([(2.5, 0.0), (2.5, 40.0)], 40.0 / points_along, seed, inward=True, axis=0)


def cave(spacing=0.06):
    """Open at both ends, wide at one of them, evenly dense."""
    return revolved([(2.5, 0.0), (2.2, 5.0), (3.0, 10.0), (2.0, 15.0)], spacing, inward=True, axis=0)


def facade(rays=80_000):
    """A wall with windows, and nothing else."""
    walls = holed_wall([0, 10, 0], [12, 0, 0], [0, 0, 8], (0.4, 0.3, 0.6, 0.6))
    return scanned(walls, [[6, 4, 1.6]], rays, nadir=-30.0)


def courtyard(rays=160_000):
    """Houses around, the sky above."""
    walls = box([0, 0, 0], [12, 9, 6])[:5] + box([5, 4, 0], [6, 5, 1.0])
    return scanned(walls, [[2.5, 2.0, 1.5], [9.0, 7.0, 1.5]], rays // 2)


def house_from_around(rays=200_000):
    """A block seen from four sides, with the ground it stands on."""
    walls = box([0, 0, 0], [9, 7, 5]) + [rectangle([-12, -12, 0], [33, 0, 0], [0, 31, 0])]
    return scanned(walls, [[-6, -6, 1.6], [15, -6, 1.6], [15, 13, 1.6], [-6, 13, 1.6]], rays // 4)


def block_from_six_sides(rays=150_000):
    """From places close in front of its sides: as dense as a room seen from its middle."""
    places = [[-1, 1, 1], [4, 1, 1], [1.5, -1, 1], [1.5, 3, 1], [1.5, 1, 3], [1.5, 1, -1]]
    return scanned(box([0, 0, 0], [3, 2, 2]), places, rays, nadir=-89.0)


def block_from_five_sides(rays=150_000):
    """Nothing of its bottom is seen."""
    places = [[-2, -2, 1], [5, -2, 1], [5, 4, 1], [-2, 4, 1], [1.5, 1, 5]]
    return scanned(box([0, 0, 0], [3, 2, 2]), places, rays, nadir=-89.0)


# Terrain.

def height(x, y):
    return 1.2 * np.sin(x / 7.0) * np.cos(y / 6.0) + 0.06 * x


def height_normal(x, y):
    slope_x = 1.2 / 7.0 * np.cos(x / 7.0) * np.cos(y / 6.0) + 0.06
    slope_y = -1.2 / 6.0 * np.sin(x / 7.0) * np.sin(y / 6.0)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], 1)
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def jittered_square(side, points, random):
    steps = int(np.sqrt(points))
    places = (np.stack(np.meshgrid(np.arange(steps), np.arange(steps)), -1).reshape(-1, 2) + 0.5 +
              random.uniform(-0.3, 0.3, (steps * steps, 2)))
    return places * side / steps


def tree_places(side, trees, random):
    return random.uniform(0.08, 0.92, (trees, 2)) * side


def leaves(center, radius, count, random):
    directions = random.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    positions = center + radius * random.uniform(0.5, 1.0, count)[:, None] * directions
    return Cloud(positions, np.zeros((count, 3)))


def trunk(x, y, radius, top, spacing, random):
    cloud = revolved([(radius, 0.0), (radius, top)], spacing, int(random.integers(1 << 30)))
    return Cloud(cloud.positions + [x, y, height(x, y)], cloud.normals)


def forest(points=80_000, trees=14, airborne=False, leafy=True, seed=3):
    """Hills with trees: stems and crowns; from the air no stems, and a third of the ground below crowns."""
    random, side = np.random.default_rng(seed), 40.0
    places = jittered_square(side, points, random)
    stems = tree_places(side, trees, random)
    distance = np.sqrt(((places[:, None] - stems[None]) ** 2).sum(axis=2)).min(axis=1)
    kept = (distance > 2.2) | (random.uniform(size=len(places)) < 0.33) if airborne else distance > 0.25
    x, y = places[kept].T
    cloud = Cloud(np.stack([x, y, height(x, y) + 0.01 * random.standard_normal(len(x))], 1), height_normal(x, y))
    for x, y in stems:
        crown = np.array([x, y, height(x, y) + 6.0])
        if not airborne:
            cloud += trunk(x, y, 0.2, 4.5, 0.1, random)
        if leafy:
            found = leaves(crown, 2.2, 1500, random)
            cloud += Cloud(found.positions[found.positions[:, 2] > crown[2] - 0.5], found.normals[
                found.positions[:, 2] > crown[2] - 0.5]) if airborne else found
    return cloud


# Surfaces of revolution.

def revolved(profile, spacing, seed=1, inward=False, axis=2):
    """Points at distances of about `spacing` on the surface that a polyline of (radius, height) makes around an axis;
    normals to the right of the polyline's direction of travel upward, which is outward; or the other way."""
    random, clouds = np.random.default_rng(seed), []
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        length = np.hypot(r1 - r0, z1 - z0)
        steps = max(1, round(length / spacing))
        for k in range(steps):
            share = (k + 0.5) / steps
            radius, z = r0 + share * (r1 - r0), z0 + share * (z1 - z0)
            count = max(1, round(2 * np.pi * radius / spacing))
            angle = 2 * np.pi * (np.arange(count) + random.uniform() + random.uniform(-0.25, 0.25, count)) / count
            jitter = random.uniform(-0.25, 0.25, count) * spacing
            radii, heights = radius + jitter * (r1 - r0) / length, z + jitter * (z1 - z0) / length
            cosine, sine = np.cos(angle), np.sin(angle)
            right, upward = (z1 - z0) / length, -(r1 - r0) / length
            clouds.append(Cloud(np.stack([radii * cosine, radii * sine, heights], 1),
                                np.stack([right * cosine, right * sine, np.full(count, upward)], 1)))
    positions = np.concatenate([cloud.positions for cloud in clouds])
    normals = np.concatenate([cloud.normals for cloud in clouds]) * (-1.0 if inward else 1.0)
    order = np.roll(np.arange(3), axis + 1)  # the axis of revolution comes last
    return Cloud(positions[:, order], normals[:, order])


def arc(radius, begin, end, steps=24):
    """(radius, height) along a circle around the origin; angles from straight down, in degrees."""
    angles = np.radians(np.linspace(begin, end, steps + 1))
    return [(radius * np.sin(a), -radius * np.cos(a)) for a in angles]


def ball(radius, spacing, center=(0, 0, 0), inward=False, seed=1):
    cloud = revolved(arc(radius, 0, 180), spacing, seed, inward)
    return Cloud(cloud.positions + np.array(center, float), cloud.normals)


def bowl(gap=3.0, spacing=0.02, opening=90.0):
    """Both sides of a wall `gap` spacings thick; open upward from `opening` degrees on (180: closed)."""
    thick = gap * spacing
    return revolved(arc(1.0, 0, opening) + arc(1.0 - thick, opening, 0), spacing)


def vase(gap=3.0, spacing=0.02):
    """A belly and a narrow neck, with a wall of `gap` spacings, both sides seen."""
    outer = [(0.0, 0.0), (0.5, 0.0), (0.8, 0.6), (0.75, 1.2), (0.3, 1.7), (0.35, 2.1)]
    thick = gap * spacing
    inner = [(r - thick if r > thick else 0.0, max(z, thick)) for r, z in outer[1:]]
    return revolved(outer + inner[::-1] + [(0.0, thick)], spacing)


def shell_of_bowl(spacing=0.02):
    """The outer side of a bowl alone."""
    return revolved(arc(1.0, 0, 90), spacing)


def hollow_ball(gap, spacing=0.025):
    """Two balls within one another with what is solid between them: seen by tomography."""
    return ball(1.0, spacing) + ball(1.0 - gap * spacing, spacing, inward=True, seed=2)


def ball_in_room(rays=120_000):
    """A ball that hangs free in a room."""
    cloud = scanned(box([0, 0, 0], [5, 4, 2.6]), [[1.2, 1.0, 1.4], [3.9, 3.1, 1.4]], rays // 2)
    return cloud + ball(0.35, 0.02, (2.5, 2.0, 1.5))


def floor_around(side, spacing, hidden, seed=1):
    """A square floor without discs: (x, y, radius)."""
    x, y = jittered_square(side, int((side / spacing) ** 2), np.random.default_rng(seed)).T - side / 2.0
    kept = np.ones(len(x), bool)
    for at_x, at_y, radius in hidden:
        kept &= np.hypot(x - at_x, y - at_y) > radius
    positions = np.stack([x, y, np.zeros_like(x)], 1)[kept]
    return Cloud(positions, np.tile(UP, (len(positions), 1)))


def not_hidden(cloud, places, balls):
    """What one of the places sees: it faces the place, and no ball (center, radius) stands between."""
    seen = np.zeros(len(cloud.positions), bool)
    for place in np.asarray(places, float):
        ways = place - cloud.positions
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        free = (ways * cloud.normals).sum(axis=1) > 0.05
        for center, radius in balls:
            offset = cloud.positions - center
            along = (offset * ways).sum(axis=1)
            depth = along * along - (offset * offset).sum(axis=1) + radius * radius
            free &= ~((depth > 0.0) & (np.sqrt(np.maximum(depth, 0.0)) - along > 1e-3 * radius) &
                      (np.linalg.norm(offset, axis=1) > (1.0 + 1e-9) * radius))
        seen |= free
    return Cloud(cloud.positions[seen], cloud.normals[seen])


def balls_on_a_floor(spacing=0.02):
    """Seen from four tripods: the floor below a ball, and the ball's lowest part, are hidden."""
    balls = [(np.array([x, y, radius]), radius)
             for x, y, radius in ((0, 0, 0.35), (1, 1, 0.5), (-1, 0.7, 0.25), (-1, -1.2, 0.6))]
    cloud = floor_around(5.0, spacing, [])
    for seed, (center, radius) in enumerate(balls):
        cloud += ball(radius, spacing, center, seed=seed)
    return not_hidden(cloud, [[x, y, 1.5] for x in (-2, 2) for y in (-2, 2)], balls)


def mug_on_a_table(spacing=0.02):
    """Outer and inner side of a mug, and the table that it stands on."""
    mug = revolved([(0.4, 0.0), (0.5, 1.0), (0.44, 1.0), (0.35, 0.06), (0.0, 0.06)], spacing)
    return mug + floor_around(4.0, spacing, [(0.0, 0.0, 0.41)])


def two_balls(spacing=0.03):
    return ball(1.0, spacing) + ball(0.6, spacing, (2.2, 0.3, 0.2), seed=2)


def waves(points=30_000, tilt=0.0, seed=1):
    """An open sheet, tilted by `tilt` degrees about the x axis."""
    random = np.random.default_rng(seed)
    x, y = jittered_square(4.0, points, random).T
    z = 0.2 * np.sin(2 * x) * np.sin(2 * y)
    normals = np.stack([-0.4 * np.cos(2 * x) * np.sin(2 * y), -0.4 * np.sin(2 * x) * np.cos(2 * y),
                        np.ones_like(x)], 1)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    angle = np.radians(tilt)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    return Cloud(np.stack([x, y, z], 1) @ turn.T, normals @ turn.T)
