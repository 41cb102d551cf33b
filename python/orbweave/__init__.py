"""Surface reconstruction of point clouds: points in, one seamless triangle mesh out.

    import numpy, orbweave
    mesh = orbweave.reconstruct(points)            # (N, 3) float64
    orbweave.write_mesh("mesh.ply", mesh)          # the bytes that the program orbweave writes
    report = orbweave.run("job.toml")              # files of any size, in bounded memory

docs/python.md explains it.
"""
from collections.abc import Mapping

from . import _orbweave
from ._errors import (BadInputError, DefectError, Interrupted, OrbweaveError, OrbweaveWarning, ResourceError,
                      UsageError)
from ._orbweave import Hole, Mesh, PointCloud, __version__
from ._settings import flag, pairs, pairs_of_sections, path_bytes, unicode_text

__all__ = ["BadInputError", "DefectError", "Hole", "Interrupted", "Mesh", "OrbweaveError", "OrbweaveWarning",
           "PointCloud", "ResourceError", "UsageError", "__version__", "inspect", "job_defaults", "plan", "read_mesh",
           "read_points", "reconstruct", "run", "write_mesh", "write_points"]


def reconstruct(points, normals=None, *, attributes=None, scanners=None, ball_radii=None, levels=None, source=None,
                neighbors=None, orientation=None, viewpoint=None, up=None, fill=None, kernel=None, neighborhood=None,
                max_diameter=None, max_perimeter=None, max_edges=None, keep_outer_border=None,
                allow_intersections=None, graded=None, min_triangles=None, keep_strays=None, threads=None,
                progress=None):
    """Reconstructs the surface of points in memory and returns a Mesh.

    points: an array of shape (N, 3), or a PointCloud. Float64 in C order is read where it lies; anything else is
    converted first. The library copies the points once, into the order of the mesh, and needs some 400 bytes per point.
    normals: likewise, or None to estimate them. Normals of float32 keep that width in a file of the mesh.
    attributes: a dictionary of names and arrays with a number per point, which the vertices carry.
    scanners: where each point was seen from, an array of shape (N, 3), or one place for all, (1, 3). Estimated normals
    point there.

    The options have the names, values and defaults of the keys of a job (`orbweave config --reference`): ball_radii and
    levels of [reconstruct]; source, neighbors, orientation, viewpoint and up of [normals]; fill (enabled) and the others
    of [fill]; keep_strays of [input]; threads of [run]. None: the default.

    progress: called with the name of a stage and the share of the stages that are done. What it raises ends the call.

    The vertices are points of the cloud, unmoved, in an order that does not depend on that of the points, then the
    vertices of patches. Raises UsageError, BadInputError (no triangle can be formed), MemoryError, KeyboardInterrupt.
    """
    settings = pairs({
        "reconstruct.ball_radii": ball_radii, "reconstruct.levels": levels, "normals.source": source,
        "normals.neighbors": neighbors, "normals.orientation": orientation, "normals.viewpoint": viewpoint,
        "normals.up": up, "fill.enabled": fill, "fill.kernel": kernel, "fill.neighborhood": neighborhood,
        "fill.max_diameter": max_diameter, "fill.max_perimeter": max_perimeter, "fill.max_edges": max_edges,
        "fill.keep_outer_border": keep_outer_border, "fill.allow_intersections": allow_intersections,
        "fill.graded": graded, "fill.min_triangles": min_triangles, "input.keep_strays": keep_strays,
        "run.threads": threads})
    if isinstance(points, PointCloud):
        if normals is not None or attributes is not None:
            raise UsageError("a PointCloud has its normals and attributes already", place="normals",
                             problem="normals or attributes beside a PointCloud", expected="None")
        return _orbweave.reconstruct_cloud(points, scanners, settings, progress)
    if attributes is not None:
        cloud = PointCloud(points, normals, attributes=attributes)
        return _orbweave.reconstruct_cloud(cloud, scanners, settings, progress)
    return _orbweave.reconstruct_arrays(points, normals, scanners, settings, progress)


def _written_job(job, settings):
    """(file, text, settings) of a job as it is given."""
    more = pairs({} if settings is None else settings)
    if isinstance(job, Mapping):
        return "", "", pairs_of_sections(job) + more
    if isinstance(job, str) and "\n" in job:
        return "", unicode_text("the text of the job", job), more
    return path_bytes(job), "", more


def run(job, *, settings=None, fresh=False, progress=None):
    """Runs a job, as `orbweave run` does, and returns its report as a dictionary.

    job: the path of a job file; or its text (TOML, of several lines); or a dictionary of sections,
    {"input": {"files": ["scan.ply"]}, "output": {"mesh": "mesh.ply"}}. Relative paths are relative to the job file, or to
    the current directory. settings: further keys, {"partition.memory": "1GiB"}, which win over the job's. fresh: drops
    what an interrupted run left; otherwise the same call resumes. progress: called with the name of a stage and the
    share of the job's time that is over, as far as that is known. Warnings of the run are warnings (OrbweaveWarning).

    One run at a time: the memory budget is that of the process. Raises OrbweaveError, KeyboardInterrupt.
    """
    return _orbweave.run(*_written_job(job, settings), flag("fresh", fresh), progress)


def plan(job, *, settings=None, progress=None):
    """Says what a run of the job would do and need, as a dictionary. Writes nothing. Arguments as of run().

    files; points_read of them, points_dropped by reason, points that are left, their bounds; doubts, a sentence each; chunks,
    chunk_points (the limit), largest_chunk_points, chunks_in_flight, halo_width; ball_radii; peak_memory_bytes, disk_bytes and
    seconds, as predicted; holes: those that are known where an interrupted run of the job left them, otherwise None.
    """
    return _orbweave.plan(*_written_job(job, settings), progress)


def read_points(path):
    """Reads a cloud of any format that the program reads, whole, and returns a PointCloud. What the file holds and a
    PointCloud has no place for, such as where scanners stood, is warned of (OrbweaveWarning)."""
    return _orbweave.read_points(path_bytes(path))


def read_mesh(path):
    """Reads a mesh (.ply, .obj, .stl, .glb, .gltf, each also with .gz) and returns a Mesh. What the file holds and a Mesh has
    no place for is warned of (OrbweaveWarning)."""
    return _orbweave.read_mesh(path_bytes(path))


def _check_type(name, value, type_):
    if not isinstance(value, type_):
        raise TypeError(f"{name} is to be an orbweave.{type_.__name__}, not {type(value).__name__}")


def write_mesh(path, mesh, *, binary=True, float_positions=False, origin=(0.0, 0.0, 0.0)):
    """Writes a mesh (.ply, also .ply.gz, .obj, .stl, .glb, .vtp, .xdmf). origin is subtracted from the coordinates, and the
    file .shift.txt beside it, which every reader adds, says so. The coordinate system goes into the .prj beside it; one that was
    there before and is another is warned of (OrbweaveWarning). The file has its name when it is complete."""
    _check_type("mesh", mesh, Mesh)
    _orbweave.write_mesh(path_bytes(path), mesh, flag("binary", binary), flag("float_positions", float_positions), origin)


def write_points(path, cloud, *, binary=True, float_positions=False, origin=(0.0, 0.0, 0.0)):
    """Writes a PointCloud (.ply, .xyz, .csv, each also with .gz). origin is as that of write_mesh."""
    _check_type("cloud", cloud, PointCloud)
    _orbweave.write_points(path_bytes(path), cloud, flag("binary", binary), flag("float_positions", float_positions), origin)


def inspect(mesh):
    """Counts and checks a Mesh: what `orbweave inspect --json` counts of it, as a dictionary, but for triangles that cross
    (crossing_pairs is None: not looked for) and the list of loops."""
    _check_type("mesh", mesh, Mesh)
    return mesh.facts()


def job_defaults():
    """The text of a job file with every key, explained, at its default (`orbweave config --defaults`)."""
    return _orbweave.job_defaults()
