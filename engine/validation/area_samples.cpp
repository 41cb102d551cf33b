#include "engine/validation/area_samples.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orbweave {
namespace {

/// Twice the area vector.
Vec3 area_normal(const TriangleMesh& mesh, const Triangle& t) {
  const std::vector<Vec3>& p = mesh.vertices.positions;
  return cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

/// Areas of the triangles up to each of them.
std::vector<double> summed_areas(const TriangleMesh& mesh) {
  std::vector<double> sums;
  sums.reserve(mesh.triangles.size());
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const double area = 0.5 * norm(area_normal(mesh, t));
    if (std::isfinite(area)) sum += area;
    sums.push_back(sum);
  }
  return sums;
}

double fraction(double x) { return x - std::floor(x); }

}  // namespace

AreaSamples sample_by_area(const TriangleMesh& mesh, std::uint64_t count) {
  // The root of x^3 = x + 1.
  constexpr double kPlastic = 1.32471795724474602596;
  AreaSamples samples;
  const std::vector<double> sums = summed_areas(mesh);
  if (sums.empty() || !(sums.back() > 0.0)) return samples;
  const auto last = std::lower_bound(sums.begin(), sums.end(), sums.back());
  samples.positions.reserve(count);
  samples.normals.reserve(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto number = static_cast<double>(k);
    const double wanted = (number + 0.5) / static_cast<double>(count) * sums.back();
    // The first triangle whose sum is beyond the wanted area has an area itself.
    const auto at = std::min(std::upper_bound(sums.begin(), sums.end(), wanted), last);
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(at - sums.begin())];
    double u = fraction(0.5 + number / kPlastic), v = fraction(0.5 + number / kPlastic / kPlastic);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    const std::vector<Vec3>& p = mesh.vertices.positions;
    samples.positions.push_back(p[t[0]] + u * (p[t[1]] - p[t[0]]) + v * (p[t[2]] - p[t[0]]));
    samples.normals.push_back(normalized(area_normal(mesh, t)));
  }
  return samples;
}

}  // namespace orbweave
