#include "engine/geometry/symmetric_eigen.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace orbweave {
namespace {

struct Rotating {
  double diagonal[3];
  double beside[3];  // beside[i]: the entry of rows (i + 1) % 3 and (i + 2) % 3
  Vec3 vectors[3];

  /// Turns rows p and q so that their entry becomes 0; r is the third row.
  void rotate(int p, int q, int r) {
    const double entry = beside[r];
    if (entry == 0.0) return;
    const double theta = (diagonal[q] - diagonal[p]) / (2.0 * entry);
    // The smaller of the two angles; theta may overflow to infinity, then t is 0.
    const double t =
        (theta < 0.0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
    const double c = 1.0 / std::sqrt(t * t + 1.0);
    const double s = t * c;
    diagonal[p] -= t * entry;
    diagonal[q] += t * entry;
    beside[r] = 0.0;
    const double at_p = beside[q], at_q = beside[p];  // entries (p, r) and (q, r)
    beside[q] = c * at_p - s * at_q;
    beside[p] = s * at_p + c * at_q;
    const Vec3 vp = vectors[p], vq = vectors[q];
    vectors[p] = c * vp - s * vq;
    vectors[q] = s * vp + c * vq;
  }
};

/// Equal values keep their order.
std::array<int, 3> ascending(const double (&values)[3]) {
  std::array<int, 3> order{0, 1, 2};
  if (values[1] < values[0]) std::swap(order[0], order[1]);
  if (values[2] < values[order[1]]) {
    std::swap(order[1], order[2]);
    if (values[2] < values[order[0]]) std::swap(order[0], order[1]);
  }
  return order;
}

}  // namespace

SymmetricEigen eigen_of(const SymmetricMatrix& m) {
  const double scale = std::max({std::abs(m.xx), std::abs(m.yy), std::abs(m.zz), std::abs(m.xy),
                                 std::abs(m.xz), std::abs(m.yz)});
  if (!(scale > 0.0)) return {};
  Rotating a{{m.xx / scale, m.yy / scale, m.zz / scale},
             {m.yz / scale, m.xz / scale, m.xy / scale},
             {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  // Converges quadratically: three to five sweeps. The limit is for values that are no numbers.
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double left = std::abs(a.beside[0]) + std::abs(a.beside[1]) + std::abs(a.beside[2]);
    if (!(left > std::numeric_limits<double>::epsilon())) break;
    a.rotate(0, 1, 2);
    a.rotate(0, 2, 1);
    a.rotate(1, 2, 0);
  }
  const std::array<int, 3> order = ascending(a.diagonal);
  SymmetricEigen result;
  for (int i = 0; i < 3; ++i) {
    result.values[i] = a.diagonal[order[i]] * scale;
    result.vectors[i] = normalized(a.vectors[order[i]]);
  }
  return result;
}

std::array<SymmetricEigen, 4> eigen_of_four(const std::array<SymmetricMatrix, 4>& matrices,
                                            const SurfaceKernel& kernel) {
  FourMatrices four;
  for (int i = 0; i < 4; ++i) {
    const SymmetricMatrix& m = matrices[i];
    four.xx[i] = m.xx;
    four.xy[i] = m.xy;
    four.xz[i] = m.xz;
    four.yy[i] = m.yy;
    four.yz[i] = m.yz;
    four.zz[i] = m.zz;
  }
  FourEigen eigen;
  kernel.eigen(four, eigen);
  std::array<SymmetricEigen, 4> results;
  for (int i = 0; i < 4; ++i) {
    const double values[3] = {eigen.values[0][i], eigen.values[1][i], eigen.values[2][i]};
    const std::array<int, 3> order = ascending(values);
    for (int k = 0; k < 3; ++k) {
      const auto& vector = eigen.vectors[order[k]];
      results[i].values[k] = values[order[k]];
      results[i].vectors[k] = {vector[0][i], vector[1][i], vector[2][i]};
    }
  }
  return results;
}

}  // namespace orbweave
