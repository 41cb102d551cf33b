// The loops over a neighbourhood's points of moving least squares and of normals, for several
// vector widths. Units compiled for other machines include this header: it defines nothing.
#pragma once

#include <cstdint>

namespace orbweave {

/// Points in columns, for several lanes. Columns have room for four values more than there are
/// points.
struct LaneColumns {
  double* x = nullptr;
  double* y = nullptr;
  double* z = nullptr;
  double* normal_x = nullptr;
  double* normal_y = nullptr;
  double* normal_z = nullptr;
};

/// Points near a place: offsets from it in units of a radius, squared distances, weights. Rows from
/// `count` to the next multiple of four hold points without weight.
struct NearColumns {
  LaneColumns points;
  double* squared = nullptr;
  double* weight = nullptr;
  std::uint32_t count = 0;
};

/// How far normals agree with a reference normal.
struct AgreementSums {
  double support = 0.0;                  ///< weight of normals that support the reference
  double weight = 0.0;                   ///< weight of all
  double agreeing[3] = {0.0, 0.0, 0.0};  ///< sum of the normals by weight and agreement
  double normals[3] = {0.0, 0.0, 0.0};   ///< sum of the normals by weight
};

/// Weight, weighted mean, and products of the differences from the mean: xx, xy, xz, yy, yz, zz.
struct SpreadSums {
  double weight = 0.0;
  double center[3] = {0.0, 0.0, 0.0};
  double products[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
};

/// Four symmetric matrices, entry by entry, and their eigenvalues and eigenvectors in no order.
struct FourMatrices {
  double xx[4], xy[4], xz[4], yy[4], yz[4], zz[4];
};
struct FourEigen {
  double values[3][4];
  double vectors[3][3][4];  ///< vector, axis
};

/// Every form gives the same bits: a sum is of four partial sums, point i in the (i mod 4)th.
struct SurfaceKernel {
  /// Points within `reach` (a squared distance) of a place, in their order. Rows from `count` to
  /// the next multiple of four must lie nowhere (infinity).
  void (*find_near)(const LaneColumns& points, std::uint32_t count, const double place[3],
                    double scale, double reach, NearColumns& near);
  /// A cosine of more than `supports` supports. Not oriented: both signs agree.
  void (*agreement)(const NearColumns& near, const double reference[3], bool oriented,
                    double supports, AgreementSums& sums);
  /// Weights by agreement and by distance along the surface. Returns how many are not zero.
  std::uint32_t (*weigh)(NearColumns& near, const double reference[3], bool oriented);
  void (*spread)(const NearColumns& near, SpreadSums& sums);
  /// Least squares of height = c[0] + c[1] x + c[2] y + c[3] x^2 + c[4] xy + c[5] y^2 in the frame
  /// (u, v, normal). Returns the reciprocal condition of the normal equations in the 1-norm; 0 and
  /// no c where they are singular.
  double (*fit_quadric)(const NearColumns& near, const double u[3], const double v[3],
                        const double normal[3], double c[6]);
  /// The bits of eigen_of, for four matrices.
  void (*eigen)(const FourMatrices& matrices, FourEigen& eigen);
};

SurfaceKernel surface_kernel_generic();
/// For machines with AVX2.
SurfaceKernel surface_kernel_avx2();
/// The fastest form that this machine runs.
const SurfaceKernel& surface_kernel();

}  // namespace orbweave
