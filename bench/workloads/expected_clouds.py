"""What a point cloud file holds, read as plainly as can be and apart from the program: points and bounds.
Of compressed points, what the header says."""
import pathlib
import re
import struct
import xml.etree.ElementTree as ElementTree

import numpy as np

from meshes import read_ply

FLOAT = 1e-7  # text of float properties: the program reads floats, this reader doubles


def _facts(positions, note=""):
    finite = positions[np.isfinite(positions).all(1)]
    box = (finite.min(0), finite.max(0)) if len(finite) else None
    return {"points": len(positions), "box": box, "note": note}


def _las(data, compressed):
    major, minor, header_bytes, offset = data[24], data[25], *struct.unpack_from("<HI", data, 94)
    form, length, count = data[104] & 63, *struct.unpack_from("<HI", data, 105)
    if (major, minor) >= (1, 4) and header_bytes >= 375:
        count = struct.unpack_from("<Q", data, 247)[0] or count
    scale, shift = np.array(struct.unpack_from("<3d", data, 131)), np.array(struct.unpack_from("<3d", data, 155))
    if compressed:
        high_x, low_x, high_y, low_y, high_z, low_z = struct.unpack_from("<6d", data, 179)
        return {"points": count, "box": (np.array([low_x, low_y, low_z]), np.array([high_x, high_y, high_z])),
                "note": "as its header says", "within": scale}
    rows = np.frombuffer(data, np.uint8, count * length, offset).reshape(count, length)
    withheld = rows[:, 15] & (128 if form < 6 else 4) if (major, minor) > (1, 0) else np.zeros(count)
    kept = rows[withheld == 0]
    steps = np.ascontiguousarray(kept[:, :12]).view("<i4").reshape(-1, 3)
    return _facts(steps * scale + shift, f"{int((withheld > 0).sum())} withheld" if (withheld > 0).any() else "")


def _pts(lines):
    rows = [line.split() for line in lines]
    return _facts(np.array([row[:3] for row in rows if len(row) >= 3], float).reshape(-1, 3))


def _ptx(lines):
    """Scans of columns x rows points, each behind ten lines; the last four are a matrix for row vectors. A pulse
    without return is a row of zeros."""
    pieces, at, empty = [], 0, 0
    while at < len(lines) and lines[at].strip():
        count = int(lines[at]) * int(lines[at + 1])
        matrix = np.array([line.split() for line in lines[at + 6:at + 10]], float)
        rows = np.array([line.split()[:3] for line in lines[at + 10:at + 10 + count]], float).reshape(-1, 3)
        seen = rows[(rows != 0).any(1)]
        empty += len(rows) - len(seen)
        pieces.append(seen @ matrix[:3, :3] + matrix[3, :3])
        at += 10 + count
    return _facts(np.concatenate(pieces), f"{empty} without return" if empty else "")


def _pcd(data):
    head = re.search(rb"DATA (\w+)\r?\n", data)
    words = {line.split()[0]: line.split()[1:] for line in data[:head.end()].decode().splitlines()
             if line and line[0] != "#"}
    names = [name.lower() for name in words["FIELDS"]]
    count = int(words["POINTS"][0])
    columns = [names.index(axis) for axis in "xyz"]
    if head.group(1) == b"ascii":
        rows = [line.split() for line in data[head.end():].decode().splitlines()]
        return {**_facts(np.array([[row[c] for c in columns] for row in rows[:count]], float)), "rounding": FLOAT}
    if head.group(1) != b"binary":
        return {"points": count, "box": None, "note": "compressed"}
    kinds = {"F": "f", "I": "i", "U": "u"}
    row = np.dtype([(f"{k}", f"<{kinds[kind]}{size}", (int(width),)) for k, (kind, size, width) in
                    enumerate(zip(words["TYPE"], words["SIZE"], words.get("COUNT", ["1"] * len(names))))])
    data = np.frombuffer(data, row, count, head.end())
    return _facts(np.stack([data[str(c)][:, 0] for c in columns], 1).astype(float))


def _e57(data):
    page, xml_offset, xml_length = 1024, *struct.unpack_from("<QQ", data, 24)
    content = b"".join(data[k:k + page - 4] for k in range(0, len(data), page))
    start = xml_offset // page * (page - 4) + xml_offset % page
    root = ElementTree.fromstring(content[start:start + xml_length].rstrip(b"\0"))
    counts = [int(node.get("recordCount")) for node in root.iter() if node.tag.endswith("}points")]
    return {"points": sum(counts), "box": None, "note": f"{len(counts)} scans"}


def expected(path):
    """{"points", "box": (min, max) or None, "note"}, with "rounding" where the box is exact only to that part of its
    coordinates and "within" where it merely holds all points, to so much; None for what is no cloud in space. Fails in
    its own ways on damaged files."""
    path = pathlib.Path(path)
    kind = path.suffix
    if kind == ".ply":
        vertex = read_ply(path, last="vertex")["vertex"]
        names = {name.lower(): values for name, values in vertex.items()}
        if "z" not in names:
            return None
        return {**_facts(np.stack([names[axis] for axis in "xyz"], 1).astype(float)), "rounding": FLOAT}
    if kind in (".pts", ".ptx", ".txt"):
        lines = path.read_text(encoding="latin1").splitlines()
        return _ptx(lines) if kind == ".ptx" else _pts(lines)
    readers = {".las": lambda data: _las(data, False), ".laz": lambda data: _las(data, True), ".pcd": _pcd,
               ".e57": _e57}
    return readers[kind](path.read_bytes())
