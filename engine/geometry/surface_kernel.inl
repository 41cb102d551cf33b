// Loops over the points of a neighbourhood, four at once, for the machine that the including unit
// is compiled for. No unit of this file may use anything that is shared with units compiled for
// other machines.

#include "engine/geometry/lanes.h"
#include "engine/geometry/surface_kernel.h"

namespace orbweave {
namespace {

constexpr double kInfinity = __builtin_inf();

/// Three coordinates of four points.
struct FourVectors {
  Four x, y, z;
};
inline FourVectors all(const double v[3]) { return {all(v[0]), all(v[1]), all(v[2])}; }
inline Four dot(const FourVectors& a, const FourVectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline FourVectors offsets(const NearColumns& near, std::uint32_t i) {
  return {load(near.points.x + i), load(near.points.y + i), load(near.points.z + i)};
}
inline FourVectors normals(const NearColumns& near, std::uint32_t i) {
  return {load(near.points.normal_x + i), load(near.points.normal_y + i),
          load(near.points.normal_z + i)};
}
inline void store_sum(const FourVectors& sum, double to[3]) {
  to[0] = sum_of(sum.x);
  to[1] = sum_of(sum.y);
  to[2] = sum_of(sum.z);
}

/// A bell in the squared distance in radii: much like exp(-2 t), but zero at the radius.
inline Four bell(Four t) { return (1.0 - t) * (1.0 - t); }

inline Four agreement_of(Four cosine, bool oriented) {
  return oriented ? larger(cosine, all(0.0)) : absolute(cosine);
}

/// Points that weigh nothing, up to a multiple of four.
inline void pad(NearColumns& near) {
  const LaneColumns& p = near.points;
  double* const columns[] = {p.x, p.y, p.z, p.normal_x, p.normal_y, p.normal_z, near.weight};
  for (double* column : columns) store(column + near.count, all(0.0));
  store(near.squared + near.count, all(1.0));
}

void find_near(const LaneColumns& points, std::uint32_t count, const double place[3], double scale,
               double reach, NearColumns& near) {
  const FourVectors from = all(place);
  const LaneColumns& to = near.points;
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; i < count; i += 4) {
    const Four x = scale * (load(points.x + i) - from.x);
    const Four y = scale * (load(points.y + i) - from.y);
    const Four z = scale * (load(points.z + i) - from.z);
    const Four squared = x * x + y * y + z * z;
    const unsigned bits = bits_of(squared <= all(reach));
    // Points follow each other cell by cell: four of them are often all too far.
    if (bits == 0) continue;
    const Packing packing(bits);
    packing.store(to.x + found, x);
    packing.store(to.y + found, y);
    packing.store(to.z + found, z);
    packing.store(near.squared + found, squared);
    packing.store(to.normal_x + found, load(points.normal_x + i));
    packing.store(to.normal_y + found, load(points.normal_y + i));
    packing.store(to.normal_z + found, load(points.normal_z + i));
    found += count_of(bits);
  }
  near.count = found;
  pad(near);
}

void agreement(const NearColumns& near, const double reference[3], bool oriented, double supports,
               AgreementSums& sums) {
  const FourVectors r = all(reference);
  Four support = all(0.0), weight = all(0.0);
  FourVectors agreeing{support, support, support}, mean = agreeing;
  for (std::uint32_t i = 0; i < near.count; i += 4) {
    const FourVectors n = normals(near, i);
    const Four bells = bell(load(near.squared + i));
    const Four cosine = dot(n, r);
    support += only(agreement_of(cosine, oriented) > all(supports), bells);
    weight += bells;
    // A normal of the other sign is turned, or does not agree.
    const Four share = bells * (oriented ? larger(cosine, all(0.0)) : cosine);
    agreeing.x += share * n.x;
    agreeing.y += share * n.y;
    agreeing.z += share * n.z;
    mean.x += bells * n.x;
    mean.y += bells * n.y;
    mean.z += bells * n.z;
  }
  sums.support = sum_of(support);
  sums.weight = sum_of(weight);
  store_sum(agreeing, sums.agreeing);
  store_sum(mean, sums.normals);
}

std::uint32_t weigh(NearColumns& near, const double reference[3], bool oriented) {
  const FourVectors r = all(reference);
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < near.count; i += 4) {
    const Four agreement = agreement_of(dot(normals(near, i), r), oriented);
    // Distance along the surface: a point far above it is not drawn to what lies near itself.
    const Four along = dot(offsets(near, i), r);
    const Four weight = agreement * agreement * bell(load(near.squared + i) - along * along);
    count += count_of(bits_of(weight > all(0.0)));
    store(near.weight + i, weight);
  }
  return count;
}

void spread(const NearColumns& near, SpreadSums& sums) {
  Four weight = all(0.0);
  FourVectors sum{weight, weight, weight};
  for (std::uint32_t i = 0; i < near.count; i += 4) {
    const FourVectors d = offsets(near, i);
    const Four w = load(near.weight + i);
    weight += w;
    sum.x += w * d.x;
    sum.y += w * d.y;
    sum.z += w * d.z;
  }
  sums.weight = sum_of(weight);
  store_sum(sum, sums.center);
  if (!(sums.weight > 0.0)) return;
  for (double& coordinate : sums.center) coordinate /= sums.weight;
  const FourVectors center = all(sums.center);
  Four products[6] = {};
  for (std::uint32_t i = 0; i < near.count; i += 4) {
    const FourVectors d = offsets(near, i);
    const Four w = load(near.weight + i);
    const Four x = d.x - center.x, y = d.y - center.y, z = d.z - center.z;
    const Four wx = w * x, wy = w * y;
    products[0] += wx * x;
    products[1] += wx * y;
    products[2] += wx * z;
    products[3] += wy * y;
    products[4] += wy * z;
    products[5] += w * z * z;
  }
  for (int entry = 0; entry < 6; ++entry) sums.products[entry] = sum_of(products[entry]);
}

/// Weighted sums of x^i y^j, i + j <= 4, and of height x^i y^j, i + j <= 2.
struct Moments {
  double of[5][5];
  double height[6];
};

void sum_moments(const NearColumns& near, const double u[3], const double v[3],
                 const double normal[3], Moments& moments) {
  const FourVectors u4 = all(u), v4 = all(v), normal4 = all(normal);
  Four low[6] = {}, height[6] = {}, cubic[4] = {}, quartic[5] = {};
  for (std::uint32_t i = 0; i < near.count; i += 4) {
    const FourVectors d = offsets(near, i);
    const Four w = load(near.weight + i);
    const Four x = dot(d, u4), y = dot(d, v4), h = dot(d, normal4);
    const Four xx = x * x, xy = x * y, yy = y * y;
    const Four wxx = w * xx, wyy = w * yy, wh = w * h;
    low[0] += w;
    low[1] += w * x;
    low[2] += w * y;
    low[3] += wxx;
    low[4] += w * xy;
    low[5] += wyy;
    height[0] += wh;
    height[1] += wh * x;
    height[2] += wh * y;
    height[3] += wh * xx;
    height[4] += wh * xy;
    height[5] += wh * yy;
    cubic[0] += wxx * x;
    cubic[1] += wxx * y;
    cubic[2] += wyy * x;
    cubic[3] += wyy * y;
    quartic[0] += wxx * xx;
    quartic[1] += wxx * xy;
    quartic[2] += wxx * yy;
    quartic[3] += wyy * xy;
    quartic[4] += wyy * yy;
  }
  auto& of = moments.of;
  of[0][0] = sum_of(low[0]);
  of[1][0] = sum_of(low[1]);
  of[0][1] = sum_of(low[2]);
  of[2][0] = sum_of(low[3]);
  of[1][1] = sum_of(low[4]);
  of[0][2] = sum_of(low[5]);
  for (int j = 0; j < 4; ++j) of[3 - j][j] = sum_of(cubic[j]);
  for (int j = 0; j < 5; ++j) of[4 - j][j] = sum_of(quartic[j]);
  for (int k = 0; k < 6; ++k) moments.height[k] = sum_of(height[k]);
}

/// L D L^T of a symmetric matrix: L in place below the diagonal, and the reciprocals of D. False
/// where it is not positive definite. Golub, Van Loan: Matrix Computations, 4th ed., section 4.1.2.
bool factorize(double a[6][6], double reciprocals[6]) {
  for (int j = 0; j < 6; ++j) {
    double column[6];
    for (int k = 0; k < j; ++k) column[k] = a[j][k] * a[k][k];
    for (int k = 0; k < j; ++k) a[j][j] -= a[j][k] * column[k];
    if (!(a[j][j] > 0.0)) return false;
    reciprocals[j] = 1.0 / a[j][j];
    for (int i = j + 1; i < 6; ++i) {
      for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * column[k];
      a[i][j] *= reciprocals[j];
    }
  }
  return true;
}

/// Solves for eight right sides at once.
void solve(const double a[6][6], const double reciprocals[6], Four left[6], Four right[6]) {
  for (int i = 1; i < 6; ++i) {
    for (int k = 0; k < i; ++k) {
      left[i] -= a[i][k] * left[k];
      right[i] -= a[i][k] * right[k];
    }
  }
  for (int i = 5; i >= 0; --i) {
    left[i] *= reciprocals[i];
    right[i] *= reciprocals[i];
    for (int k = i + 1; k < 6; ++k) {
      left[i] -= a[k][i] * left[k];
      right[i] -= a[k][i] * right[k];
    }
  }
}

double largest_column(const double a[6][6]) {
  double largest = 0.0;
  for (int j = 0; j < 6; ++j) {
    double sum = 0.0;
    for (int i = 0; i < 6; ++i) sum += __builtin_fabs(i < j ? a[j][i] : a[i][j]);
    if (sum > largest) largest = sum;
  }
  return largest;
}

double fit_quadric(const NearColumns& near, const double u[3], const double v[3],
                   const double normal[3], double c[6]) {
  Moments moments;
  sum_moments(near, u, v, normal, moments);
  constexpr int kX[6] = {0, 1, 0, 2, 1, 0}, kY[6] = {0, 0, 1, 0, 1, 2};
  double a[6][6];
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) a[i][j] = moments.of[kX[i] + kX[j]][kY[i] + kY[j]];
  const double norm = largest_column(a);
  double reciprocals[6];
  if (!factorize(a, reciprocals)) return 0.0;
  // The inverse's columns, then the surface, then nothing.
  Four left[6], right[6], left_sums = all(0.0), right_sums = all(0.0);
  for (int i = 0; i < 6; ++i) {
    left[i] = right[i] = all(0.0);
    if (i < 4) {
      left[i][i] = 1.0;
    } else {
      right[i][i - 4] = 1.0;
    }
    right[i][2] = moments.height[i];
  }
  solve(a, reciprocals, left, right);
  for (int i = 0; i < 6; ++i) {
    left_sums += absolute(left[i]);
    right_sums += absolute(right[i]);
    c[i] = right[i][2];
  }
  const Four most = larger(left_sums, Four{right_sums[0], right_sums[1], 0.0, 0.0});
  double inverse_norm = 0.0;
  for (int lane = 0; lane < 4; ++lane)
    if (most[lane] > inverse_norm) inverse_norm = most[lane];
  return 1.0 / (norm * inverse_norm);
}

/// Jacobi's rotations of four matrices: the operations of eigen_of, lane by lane.
struct FourRotating {
  Four diagonal[3];
  Four beside[3];
  FourVectors vectors[3];

  void rotate(FourMask turning, int p, int q, int r) {
    const Four entry = beside[r];
    const FourMask mask = turning & (entry != all(0.0));
    const Four theta = (diagonal[q] - diagonal[p]) / (2.0 * entry);
    const Four t = choose(theta < all(0.0), all(-1.0), all(1.0)) /
                   (absolute(theta) + square_root(theta * theta + 1.0));
    const Four c = 1.0 / square_root(t * t + 1.0);
    const Four s = t * c;
    diagonal[p] = choose(mask, diagonal[p] - t * entry, diagonal[p]);
    diagonal[q] = choose(mask, diagonal[q] + t * entry, diagonal[q]);
    beside[r] = choose(mask, all(0.0), beside[r]);
    turn(mask, c, s, beside[q], beside[p]);
    turn(mask, c, s, vectors[p].x, vectors[q].x);
    turn(mask, c, s, vectors[p].y, vectors[q].y);
    turn(mask, c, s, vectors[p].z, vectors[q].z);
  }

  static void turn(FourMask mask, Four c, Four s, Four& a, Four& b) {
    const Four turned_a = c * a - s * b, turned_b = s * a + c * b;
    a = choose(mask, turned_a, a);
    b = choose(mask, turned_b, b);
  }
};

void eigen(const FourMatrices& m, FourEigen& result) {
  const Four xx = load(m.xx), xy = load(m.xy), xz = load(m.xz);
  const Four yy = load(m.yy), yz = load(m.yz), zz = load(m.zz);
  const Four scale = larger(larger(larger(absolute(xx), absolute(yy)), absolute(zz)),
                            larger(larger(absolute(xy), absolute(xz)), absolute(yz)));
  const FourMask any = scale > all(0.0);
  const Four zero = all(0.0), one = all(1.0);
  FourRotating a{{only(any, xx / scale), only(any, yy / scale), only(any, zz / scale)},
                 {only(any, yz / scale), only(any, xz / scale), only(any, xy / scale)},
                 {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}}};
  constexpr double kEpsilon = 0x1p-52;
  FourMask turning = any;
  for (int sweep = 0; sweep < 30; ++sweep) {
    const Four left = absolute(a.beside[0]) + absolute(a.beside[1]) + absolute(a.beside[2]);
    turning &= left > all(kEpsilon);
    if (bits_of(turning) == 0) break;
    a.rotate(turning, 0, 1, 2);
    a.rotate(turning, 0, 2, 1);
    a.rotate(turning, 1, 2, 0);
  }
  for (int i = 0; i < 3; ++i) {
    const FourVectors& v = a.vectors[i];
    const Four length = square_root(dot(v, v));
    store(result.values[i], only(any, a.diagonal[i] * scale));
    store(result.vectors[i][0], only(any, v.x / length));
    store(result.vectors[i][1], only(any, v.y / length));
    store(result.vectors[i][2], only(any, v.z / length));
  }
}

constexpr SurfaceKernel kKernel{find_near, agreement, weigh, spread, fit_quadric, eigen};

}  // namespace
}  // namespace orbweave
