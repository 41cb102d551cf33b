#!/usr/bin/env python3
"""Counts the points of a LAS file by class, inside a box and inside a polygon, apart from orbweave.

    count_selection.py FILE.las [--box XMIN,YMIN,XMAX,YMAX] [--polygon 'X Y, X Y, ...']
                       [--drop CLASS,...]

Reads the records with struct and decides with fractions, so that a point on an edge is on it. A
point on an edge is inside, as in orbweave. Prints JSON. Withheld points are left out.
"""
import argparse
import json
import struct
from collections import Counter
from fractions import Fraction


def points_of(path):
    """(x, y, class) of the points that are not withheld."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:4] == b"LASF", "this is no LAS file"
    minor = data[25]
    offset, = struct.unpack_from("<I", data, 96)
    point_format, length, count = struct.unpack_from("<BHI", data, 104)
    assert point_format <= 10, "compressed files are not read"
    if minor >= 4:
        count = struct.unpack_from("<Q", data, 247)[0] or count
    scale = struct.unpack_from("<3d", data, 131)
    shift = struct.unpack_from("<3d", data, 155)
    for i in range(count):
        at = offset + i * length
        x, y = struct.unpack_from("<2i", data, at)
        if point_format < 6:
            point_class, withheld = data[at + 15] & 31, data[at + 15] >> 7
        else:
            point_class, withheld = data[at + 16], data[at + 15] >> 2 & 1
        if not withheld:
            yield x * scale[0] + shift[0], y * scale[1] + shift[1], point_class


def is_inside(ring, x, y):
    """Even-odd rule with fractions; a point on an edge is inside."""
    x, y = Fraction(x), Fraction(y)
    inside = False
    for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
        if not min(ay, by) <= y <= max(ay, by):
            continue
        if ay == by:
            if min(ax, bx) <= x <= max(ax, bx):
                return True
            continue
        crossing = ax + (y - ay) * (bx - ax) / (by - ay)
        if crossing == x:
            return True
        if (ay <= y) != (by <= y) and crossing > x:
            inside = not inside
    return inside


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("--box")
    parser.add_argument("--polygon")
    parser.add_argument("--drop", default="")
    arguments = parser.parse_args()
    box = [float(word) for word in arguments.box.split(",")] if arguments.box else None
    ring = None
    if arguments.polygon:
        ring = [tuple(Fraction(float(word)) for word in corner.split())
                for corner in arguments.polygon.split(",")]
    dropped = {int(word) for word in arguments.drop.split(",") if word}
    classes, kept, points = Counter(), 0, 0
    in_box, in_ring = 0, 0
    for x, y, point_class in points_of(arguments.file):
        points += 1
        classes[point_class] += 1
        of_box = box is None or (box[0] <= x <= box[2] and box[1] <= y <= box[3])
        of_ring = ring is None or is_inside(ring, x, y)
        in_box += of_box
        in_ring += of_ring
        kept += of_box and of_ring and point_class not in dropped
    print(json.dumps({"points": points, "classes": dict(sorted(classes.items())),
                      "in_box": in_box, "in_polygon": in_ring, "kept": kept}))


if __name__ == "__main__":
    main()
