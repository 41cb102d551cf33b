// Reconstructs a cloud in memory: a sphere of points without normals.
#include <orbweave/reconstruct.h>

#include <cmath>
#include <cstdio>
#include <utility>

int main() {
  orbweave::PointCloud cloud;
  for (int i = 0; i < 2000; ++i) {  // points on a spiral, evenly apart
    const double z = 1.0 - (2.0 * i + 1.0) / 2000.0;
    const double angle = 2.399963229728653 * i, r = std::sqrt(1.0 - z * z);
    cloud.positions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  try {
    const orbweave::Reconstruction result = orbweave::reconstruct(std::move(cloud));
    std::printf("%zu vertices, %zu triangles, %zu holes\n", result.mesh.vertices.size(),
                result.mesh.triangles.size(), result.holes.size());
    return result.mesh.vertices.size() >= 2000 ? 0 : 1;
  } catch (const orbweave::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
