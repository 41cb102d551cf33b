#include "engine/normals/normals_from_faces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>

#include "engine/geometry/point_tree.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// Sums at vertices, and how much was summed: what cancels is known from the ratio of both.
struct NormalSum {
  Vec3 sum;
  double weight = 0.0;
};

/// Faces that cancel leave rounding noise, about 2^-52 of what was summed; anything near that
/// points nowhere.
constexpr double kCancelled = 1e-12;

std::vector<NormalSum> summed_normals(const TriangleMesh& mesh) {
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  std::vector<NormalSum> sums(positions.size());
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t index : t)
      if (index >= positions.size())
        throw_bad_input("a triangle has a vertex that does not exist",
                        {.file = {},
                         .place = {},
                         .found = "index " + std::to_string(index),
                         .expected = "less than " + std::to_string(positions.size()),
                         .advice = {}});
    const Vec3 a = positions[t[0]];
    const Vec3 twice_area = cross(positions[t[1]] - a, positions[t[2]] - a);
    const double weight = norm(twice_area);
    for (const std::uint32_t index : t) {
      sums[index].sum = sums[index].sum + twice_area;
      sums[index].weight += weight;
    }
  }
  return sums;
}

}  // namespace

std::vector<Vec3> normals_from_faces(const TriangleMesh& mesh) {
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  const std::vector<NormalSum> sums = summed_normals(mesh);
  std::vector<Vec3> normals(positions.size());
  std::vector<std::uint32_t> with, without;
  std::vector<Vec3> places;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    if (is_finite(positions[v]) && norm(sums[v].sum) > kCancelled * sums[v].weight) {
      normals[v] = normalized(sums[v].sum);
      with.push_back(v);
      places.push_back(positions[v]);
    } else if (is_finite(positions[v])) {
      without.push_back(v);
    }
  }
  if (with.empty() || without.empty()) return normals;
  const PointTree tree(places);
  tbb::parallel_for(std::size_t{0}, without.size(), [&](std::size_t i) {
    const std::uint32_t v = without[i];
    normals[v] = normals[with[tree.nearest(positions[v]).index]];
  });
  return normals;
}

}  // namespace orbweave
