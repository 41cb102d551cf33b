// Reconstructs points that the program keeps in arrays of its own: nothing is copied but into the
// order in which the mesh has them. Every vertex of the mesh is one of the points.
#include <orbweave/reconstruct.h>

#include <array>
#include <cstdio>
#include <vector>

int main() {
  // A cube's surface, with normals; a lattice of 20 x 20 points per face.
  std::vector<orbweave::Vec3> positions, normals;
  constexpr int kSide = 20;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      for (int i = 0; i < kSide; ++i) {
        for (int j = 0; j < kSide; ++j) {
          orbweave::Vec3 p, n;
          p[axis] = n[axis] = sign;
          p[(axis + 1) % 3] = (2.0 * i + 1.0) / kSide - 1.0;
          p[(axis + 2) % 3] = (2.0 * j + 1.0) / kSide - 1.0;
          positions.push_back(p);
          normals.push_back(n);
        }
      }
    }
  }
  orbweave::ReconstructionOptions options;
  options.ball_radii = {0.08, 0.12};
  options.fill.max_edges = 200;  // larger holes stay open
  try {
    const orbweave::Reconstruction result = orbweave::reconstruct(positions, normals, options);
    for (const orbweave::HoleFacts& hole : result.holes)
      std::printf("a hole of %llu edges, %s\n", static_cast<unsigned long long>(hole.edges),
                  hole.filled ? "filled" : hole.reason.c_str());
    std::printf("%zu triangles\n", result.mesh.triangles.size());
    return result.mesh.triangles.size() > positions.size() ? 0 : 1;
  } catch (const orbweave::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
