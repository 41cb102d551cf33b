// Eigenvalues and eigenvectors of symmetric 3x3 matrices, bit for bit the same on every machine
// with IEEE arithmetic: additions, multiplications, divisions and square roots alone.
#pragma once

#include <array>

#include "engine/geometry/surface_kernel.h"
#include "io/vec3.h"

namespace orbweave {

struct SymmetricMatrix {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
  SymmetricMatrix& operator+=(const SymmetricMatrix& b) {
    xx += b.xx;
    xy += b.xy;
    xz += b.xz;
    yy += b.yy;
    yz += b.yz;
    zz += b.zz;
    return *this;
  }
};

inline SymmetricMatrix outer(Vec3 a) {
  return {a.x * a.x, a.x * a.y, a.x * a.z, a.y * a.y, a.y * a.z, a.z * a.z};
}

struct SymmetricEigen {
  std::array<double, 3> values{};  ///< ascending
  std::array<Vec3, 3> vectors{};   ///< unit, perpendicular to each other; of either sign
};

/// Cyclic Jacobi rotations: Golub, Van Loan, Matrix Computations, 4th ed., section 8.5. Relative
/// accuracy is that of the largest eigenvalue, at any scale. All zero for a zero matrix.
SymmetricEigen eigen_of(const SymmetricMatrix& matrix);
/// The same bits, for four matrices in about the time of one.
std::array<SymmetricEigen, 4> eigen_of_four(const std::array<SymmetricMatrix, 4>& matrices,
                                            const SurfaceKernel& kernel = surface_kernel());

}  // namespace orbweave
