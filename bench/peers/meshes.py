"""PLY clouds and meshes in numpy, and edge counts of a mesh. Written for the benchmarks alone, apart
from the program's own reader and validator, so that neither vouches for itself."""
import gzip

import numpy as np

_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
          "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
          "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8",
          "float64": "f8"}


def _read_header(stream):
    if stream.readline().strip() != b"ply":
        raise ValueError("not a PLY file")
    layout, elements = None, []
    for line in stream:
        words = line.decode("latin1").split()
        if not words:
            continue
        if words[0] == "format":
            layout = words[1]
        elif words[0] == "element":
            elements.append((words[1], int(words[2]), []))
        elif words[0] == "property":
            elements[-1][2].append(words[1:])
        elif words[0] == "end_header":
            return layout, elements
    raise ValueError("PLY header without end")


def _row_type(properties, order, list_length):
    fields = []
    for words in properties:
        if words[0] == "list":
            fields.append((words[3] + " count", order + _TYPES[words[1]]))
            fields.append((words[3], order + _TYPES[words[2]], (list_length,)))
        else:
            fields.append((words[1], order + _TYPES[words[0]]))
    return np.dtype(fields)


def _read_ascii_rows(stream, count, properties):
    values = np.loadtxt(stream, max_rows=count, ndmin=2) if count else np.zeros((0, 1))
    names, column = {}, 0
    for words in properties:
        if words[0] == "list":
            names[words[3]] = values[:, column + 1:column + 4].astype(np.int64)
            column += 4
        else:
            names[words[1]] = values[:, column]
            column += 1
    return names


def read_ply(path, last=None):
    """{element: {property: array}}; list properties are triangles, shape (n, 3). Nothing behind the element
    `last` is read."""
    opened = gzip.open if str(path).endswith(".gz") else open
    result = {}
    with opened(path, "rb") as stream:
        layout, elements = _read_header(stream)
        for name, count, properties in elements:
            if layout == "ascii":
                result[name] = _read_ascii_rows(stream, count, properties)
                if name == last:
                    break
                continue
            row = _row_type(properties, "<" if "little" in layout else ">", 3)
            data = np.frombuffer(stream.read(row.itemsize * count), dtype=row, count=count)
            for words in properties:
                if words[0] == "list" and (data[words[3] + " count"] != 3).any():
                    raise ValueError(f"{path}: faces that are no triangles")
            result[name] = {key: data[key] for key in row.names if not key.endswith(" count")}
            if name == last:
                break
    return result


def read_mesh(path):
    """(positions n x 3 double, triangles m x 3 int64)"""
    elements = read_ply(path)
    vertex = elements["vertex"]
    positions = np.stack([vertex[axis] for axis in "xyz"], 1).astype(np.float64)
    lists = [value for value in elements.get("face", {}).values() if value.ndim == 2]
    return positions, (lists[0].astype(np.int64) if lists else np.zeros((0, 3), np.int64))


def write_cloud(path, columns):
    """Binary PLY of a structured array: one vertex property per field."""
    names = {"f4": "float", "f8": "double", "u1": "uchar", "u2": "ushort", "i4": "int", "u4": "uint",
             "i1": "char", "i2": "short"}
    with open(path, "wb") as stream:
        lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(columns)}"]
        lines += [f"property {names[columns.dtype[name].str[1:]]} {name}"
                  for name in columns.dtype.names]
        stream.write(("\n".join(lines + ["end_header"]) + "\n").encode())
        stream.write(np.ascontiguousarray(columns).tobytes())


def edge_facts(triangles):
    """Counts over the edges of an (m, 3) array: what must-show figures are made of."""
    triangles = np.asarray(triangles, dtype=np.int64)
    facts = {"triangles": int(len(triangles)), "boundary_edges": 0, "edges_over_two": 0,
             "directed_edges_twice": 0}
    if len(triangles) == 0:
        return facts
    stride = int(triangles.max()) + 1
    tail = triangles.reshape(-1)
    head = np.roll(triangles, -1, axis=1).reshape(-1)
    directed = np.sort(tail * stride + head)
    facts["directed_edges_twice"] = int((directed[1:] == directed[:-1]).sum())
    del directed
    undirected = np.sort(np.minimum(tail, head) * stride + np.maximum(tail, head))
    starts = np.flatnonzero(np.r_[True, undirected[1:] != undirected[:-1]])
    uses = np.diff(np.r_[starts, len(undirected)])
    facts["boundary_edges"] = int((uses == 1).sum())
    facts["edges_over_two"] = int((uses > 2).sum())
    return facts
