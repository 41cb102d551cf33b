#!/usr/bin/env python3
"""Walks all borders of a tileset: whether tiles of any levels meet edge by edge.

    bench/quality/tile_borders.py FOLDER

A cut is a set of tiles that together show the whole mesh. Cuts of one level each, and two of mixed levels, are put together
by the exact places of vertices; every edge that one triangle of a tile has needs its counterpart in another tile, in the other
direction. Prints JSON: edges at borders of each cut, and how many of them have no counterpart, which are rims of the mesh,
or gaps. A closed mesh has none; exit status 1 otherwise. Places are exact where floats about the middle of any tile hold the
coordinates, as of meshes on a lattice. Tiles have to be without compression.
"""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import interpreter

interpreter.need("numpy")

import numpy as np


def column(document, binary, accessor, kind, width):
    view = document["bufferViews"][accessor["bufferView"]]
    if "extensions" in view:
        sys.exit("the tiles are compressed: make them without --tileset-compression")
    stride = view.get("byteStride", np.dtype(kind).itemsize * width)
    first = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.ndarray((accessor["count"], width), kind, binary, first, (stride, np.dtype(kind).itemsize))


def mesh_of(path):
    """Places in doubles, and corners of triangles."""
    data = path.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20:20 + length])
    binary = memoryview(data)[28 + length:]
    primitive = document["meshes"][0]["primitives"][0]
    matrix = np.array(document["nodes"][0]["matrix"]).reshape(4, 4).T
    places = column(document, binary, document["accessors"][primitive["attributes"]["POSITION"]], "<f4", 3)
    places = places.astype("f8") @ matrix[:3, :3].T + matrix[:3, 3] + 0.0
    return places, column(document, binary, document["accessors"][primitive["indices"]], "<u4", 1).reshape(-1, 3)


def open_edges(path):
    """Directed edges that one triangle of the tile has, as places of both ends."""
    places, corners = mesh_of(path)
    _, first, numbers = np.unique(keys_of(places), return_index=True, return_inverse=True)
    corners = numbers.reshape(-1)[corners].astype("i8")
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, at, count = np.unique(low * len(first) + high, return_index=True, return_counts=True)
    ends = places[first][edges[at[count == 1]]]
    return np.concatenate([keys_of(ends[:, 0])[:, None], keys_of(ends[:, 1])[:, None]], axis=1)


def keys_of(places):
    return np.ascontiguousarray(places).view("V24").reshape(-1)


def cut_of(tile, is_shown):
    if "children" not in tile or is_shown(tile):
        return [tile]
    return [shown for child in tile["children"] for shown in cut_of(child, is_shown)]


def unmatched(edges):
    """How many directed edges have no counterpart."""
    _, numbers = np.unique(edges.reshape(-1), return_inverse=True)
    numbers = numbers.reshape(-1, 2).astype("i8")
    size = numbers.max(initial=0) + 1
    ahead, ahead_count = np.unique(numbers[:, 0] * size + numbers[:, 1], return_counts=True)
    back, back_count = np.unique(numbers[:, 1] * size + numbers[:, 0], return_counts=True)
    _, in_ahead, in_back = np.intersect1d(ahead, back, return_indices=True)
    return int(len(edges) - np.minimum(ahead_count[in_ahead], back_count[in_back]).sum())


def walk(folder):
    root = json.loads((folder / "tileset.json").read_text())["root"]
    cuts = {f"level {level}": (lambda tile, level=level: tile["extras"]["level"] <= level)
            for level in range(root["extras"]["level"] + 1)}
    number = lambda tile: int(pathlib.Path(tile["content"]["uri"]).stem)
    cuts["mixed, even tiles"] = lambda tile: tile is not root and number(tile) % 2 == 0
    cuts["mixed, every third tile"] = lambda tile: tile is not root and number(tile) % 3 == 0
    known = {}
    result = []
    for name, is_shown in cuts.items():
        tiles = cut_of(root, is_shown)
        for tile in tiles:
            uri = tile["content"]["uri"]
            if uri not in known:
                known[uri] = open_edges(folder / uri)
        edges = np.concatenate([known[tile["content"]["uri"]] for tile in tiles])
        result.append({"cut": name, "tiles": len(tiles), "levels": len({tile["extras"]["level"] for tile in tiles}),
                       "border_edges": len(edges), "without_counterpart": unmatched(edges)})
    return result


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    cuts = walk(pathlib.Path(sys.argv[1]))
    print(json.dumps(cuts, indent=1))
    return 1 if any(cut["without_counterpart"] for cut in cuts) else 0


if __name__ == "__main__":
    sys.exit(main())
