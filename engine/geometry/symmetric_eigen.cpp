#include "engine/geometry/symmetric_eigen.h"

#include <algorithm>
#include <limits>

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
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int i, int j) {
    return a.diagonal[i] < a.diagonal[j] || (a.diagonal[i] == a.diagonal[j] && i < j);
  });
  SymmetricEigen result;
  for (int i = 0; i < 3; ++i) {
    result.values[i] = a.diagonal[order[i]] * scale;
    result.vectors[i] = normalized(a.vectors[order[i]]);
  }
  return result;
}

}  // namespace orbweave
