"""Points in a numpy array to a mesh in numpy arrays, and to a file. docs/python.md"""
import numpy
import orbweave

# Points on a spiral over the unit sphere, without normals.
i = numpy.arange(2000)
z = 1.0 - (2.0 * i + 1.0) / len(i)
radius, angle = numpy.sqrt(1.0 - z * z), 2.399963229728653 * i
points = numpy.column_stack([radius * numpy.cos(angle), radius * numpy.sin(angle), z])

mesh = orbweave.reconstruct(points, progress=lambda stage, done: print(f"{done:4.0%} {stage}"))

corners = mesh.vertices[mesh.triangles]  # (K, 3, 3): three corners of each triangle
sides = corners[:, 1:] - corners[:, :1]
area = 0.5 * numpy.linalg.norm(numpy.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
print(f"{len(mesh.vertices)} vertices, {len(mesh.triangles)} triangles, area {area:.3f} of {4 * numpy.pi:.3f}")
assert orbweave.inspect(mesh)["watertight"]
assert abs(area - 4 * numpy.pi) < 0.05

orbweave.write_mesh("sphere.ply", mesh)
