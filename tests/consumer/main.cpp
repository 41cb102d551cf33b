// Reconstructs twelve points through the installed libraries.
#include <orbweave/reconstruct.h>

#include <cmath>
#include <cstdio>
#include <vector>

int main() {
  std::vector<orbweave::Vec3> points;
  const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
  for (const double a : {-1.0, 1.0})
    for (const double b : {-golden, golden})
      for (const orbweave::Vec3 p : {orbweave::Vec3{0, a, b}, {a, b, 0}, {b, 0, a}})
        points.push_back(p);
  orbweave::ReconstructionOptions options;
  options.ball_radii = {1.5};  // edges are 2 long, circumradii 1.155
  try {
    // The normals of points around zero are the points.
    const orbweave::Reconstruction result = orbweave::reconstruct(points, points, options);
    std::printf("%zu triangles, 20 expected\n", result.mesh.triangles.size());
    return result.mesh.triangles.size() == 20 ? 0 : 1;
  } catch (const orbweave::Error& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
