"""What the scanner did not see: which holes there are, what became of them, which triangles close them.
docs/python.md"""
import numpy
import orbweave

# A sphere with normals and colours, and without a cap and a smaller spot.
i = numpy.arange(4000)
z = 1.0 - (2.0 * i + 1.0) / len(i)
radius, angle = numpy.sqrt(1.0 - z * z), 2.399963229728653 * i
points = numpy.column_stack([radius * numpy.cos(angle), radius * numpy.sin(angle), z])
points = points[(z < 0.8) & (numpy.linalg.norm(points - [1, 0, 0], axis=1) > 0.3)]
red = numpy.where(points[:, 0] > 0, 255, 0).astype(numpy.uint8)

mesh = orbweave.reconstruct(points, normals=points, attributes={"red": red}, max_edges=60)

for hole in mesh.holes:
    became = f"filled, confidence {hole.confidence:.2f}" if hole.filled else f"open: {hole.reason}"
    print(f"hole {hole.id} of {hole.edges} edges, {hole.diameter:.2f} across: {became}")
patches = mesh.triangles[mesh.triangle_hole > 0]
print(f"{len(patches)} of {len(mesh.triangles)} triangles are patches; {mesh.attributes['red'][patches].mean():.0f} of 255 is red")
assert len(mesh.holes) == 2
assert any(hole.filled for hole in mesh.holes)

try:
    orbweave.reconstruct(points, neighbors=1)
except orbweave.UsageError as error:  # every failure has its parts
    print(f"found {error.found}, expected {error.expected}")
