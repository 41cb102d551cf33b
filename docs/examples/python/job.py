"""Files of any size to a mesh file, in bounded memory; an interrupted run resumes. docs/python.md"""
import numpy
import orbweave

# Two scans of a bumpy plane, with normals.
x, y = numpy.meshgrid(numpy.linspace(0, 1, 60), numpy.linspace(0, 1, 60))
bumps = 0.05 * numpy.sin(9 * x) * numpy.cos(7 * y)
points = numpy.column_stack([x.ravel(), y.ravel(), bumps.ravel()])
normals = numpy.tile([0.0, 0.0, 1.0], (len(points), 1))
for part in (0, 1):
    orbweave.write_points(f"scan-{part}.ply", orbweave.PointCloud(points[part::2], normals[part::2]))

job = {"input": {"files": ["scan-*.ply"]},
       "partition": {"memory": "1GiB"},
       "output": {"mesh": "plane.ply", "report": "plane.json"}}
plan = orbweave.plan(job)
print(f"{plan['points']} points, {plan['peak_memory_bytes'] / 2**20:.0f} MiB, about {plan['seconds']:.1f} s")


class Stop(Exception):
    """Ends the run from within the callback, as Ctrl-C would."""


def stop_at_reconstruction(stage, done):
    if stage == "reconstruct":
        raise Stop


try:
    orbweave.run(job, progress=stop_at_reconstruction)
except Stop:
    print("stopped; what is done is kept")
report = orbweave.run(job)  # resumes
print(f"{report['mesh']['triangles']} triangles, {report['mesh']['boundary_loops']} boundary loop")
assert len(orbweave.read_mesh("plane.ply").triangles) == report["mesh"]["triangles"]
