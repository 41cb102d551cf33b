// Where the interior points of a patch come to rest: membrane and thin plate.
// Desbrun, Meyer, Schroeder, Barr: Implicit Fairing of Irregular Meshes using Diffusion and
// Curvature Flow, SIGGRAPH 1999, section 4 (cotangents).
#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/rbf/block_sizes.h"

namespace orbweave {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// The patch with the sheet along its rim: vertices of the patch, then the sheet's others.
struct Strip {
  std::vector<Vec3> positions;
  std::vector<CornerTriangle> triangles;
  std::vector<char> is_whole;  ///< per corner: its triangles of the sheet are all there
};

/// Half the cotangent of the angle at a, kept from vanishing and from taking over: the least
/// energy is then unique and inside the rim's hull (order 1) whatever the triangles are like.
double half_cotangent(Vec3 a, Vec3 b, Vec3 c) {
  constexpr double kLeast = 0.02;
  constexpr double kMost = 20.0;
  const double sine = norm(cross(b - a, c - a));
  const double cosine = dot(b - a, c - a);
  const double cotangent = sine > 0.0 ? cosine / sine : kMost;
  return 0.5 * std::clamp(cotangent, kLeast, kMost);
}

/// Compressed columns in the making: one entry after the other, by column and then row.
class Columns {
 public:
  Columns(Eigen::Index rows, Eigen::Index columns, std::size_t expected)
      : rows_(rows), columns_(columns) {
    begins_.reserve(static_cast<std::size_t>(columns) + 1);
    begins_.push_back(0);
    inner_.reserve(expected);
    values_.reserve(expected);
  }
  void add(int row, double value) {
    inner_.push_back(row);
    values_.push_back(value);
  }
  void end_column() { begins_.push_back(static_cast<int>(inner_.size())); }

  Sparse matrix() const {
    Sparse matrix(rows_, columns_);
    matrix.resizeNonZeros(static_cast<Eigen::Index>(inner_.size()));
    std::copy(begins_.begin(), begins_.end(), matrix.outerIndexPtr());
    std::copy(inner_.begin(), inner_.end(), matrix.innerIndexPtr());
    std::copy(values_.begin(), values_.end(), matrix.valuePtr());
    return matrix;
  }

 private:
  Eigen::Index rows_ = 0, columns_ = 0;
  std::vector<int> begins_, inner_;
  std::vector<double> values_;
};

/// A neighbour of a vertex, and what it weighs.
struct Weight {
  std::uint32_t neighbor = 0;
  double weight = 0.0;
};

/// The weights of edges at each vertex, triangle by triangle: an edge occurs once per triangle.
class EdgeWeights {
 public:
  explicit EdgeWeights(const Strip& strip)
      : first_(strip.positions.size() + 1, 0), at_vertex_(strip.positions.size(), 0.0) {
    for (const CornerTriangle& t : strip.triangles)
      for (const std::uint32_t v : t) first_[v + 1] += 2;
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    weights_.resize(first_.back());
    std::vector<std::uint32_t> place(first_.begin(), first_.end() - 1);
    for (const CornerTriangle& t : strip.triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[(k + 1) % 3], b = t[(k + 2) % 3];
        const double weight =
            half_cotangent(strip.positions[t[k]], strip.positions[a], strip.positions[b]);
        weights_[place[a]++] = {b, weight};
        weights_[place[b]++] = {a, weight};
        at_vertex_[a] -= weight;
        at_vertex_[b] -= weight;
      }
    }
  }

  /// The column of a vertex: ascending neighbours and the vertex itself, each once.
  void take_column(std::uint32_t vertex, std::vector<Weight>& column) const {
    column.assign(1, {vertex, at_vertex_[vertex]});
    for (std::uint32_t i = first_[vertex]; i < first_[vertex + 1]; ++i) {
      const auto at = std::lower_bound(
          column.begin(), column.end(), weights_[i].neighbor,
          [](const Weight& known, std::uint32_t other) { return known.neighbor < other; });
      if (at != column.end() && at->neighbor == weights_[i].neighbor)
        at->weight += weights_[i].weight;
      else
        column.insert(at, weights_[i]);
    }
  }
  std::size_t size() const { return weights_.size(); }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<Weight> weights_;
  std::vector<double> at_vertex_;
};

/// A third of the area around each vertex, no less than a thousandth of the mean.
std::vector<double> areas(const Strip& strip) {
  std::vector<double> areas(strip.positions.size(), 0.0);
  double total = 0.0;
  for (const CornerTriangle& t : strip.triangles) {
    const auto& p = strip.positions;
    const double area = norm(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) / 6.0;
    for (const std::uint32_t v : t) areas[v] += area;
    total += 3.0 * area;
  }
  const double least = 1e-3 * total / static_cast<double>(std::max<std::size_t>(areas.size(), 1));
  for (double& area : areas) area = std::max(area, least);
  return areas;
}

/// What each row of the Laplacian counts: with order 2 one by the square root of the vertex's area,
/// where the vertex moves or its triangles are all there; with order 1 minus one where it moves.
/// 0: not at all.
std::vector<double> row_scales(const Strip& strip, const std::vector<int>& unknown, int order) {
  std::vector<double> scales(unknown.size(), 0.0);
  const std::vector<double> area = order >= 2 ? areas(strip) : std::vector<double>{};
  for (std::size_t v = 0; v < unknown.size(); ++v) {
    const bool rim = order >= 2 && v < strip.is_whole.size() && strip.is_whole[v] != 0;
    if (unknown[v] < 0 && !rim) continue;
    scales[v] = order >= 2 ? 1.0 / std::sqrt(area[v]) : -1.0;
  }
  return scales;
}

/// Scaled rows of the Laplacian, the sum over the neighbours of weight x (neighbour - vertex):
/// columns of the vertices that move, and of the others times where they are.
struct Split {
  Sparse moving;
  Eigen::MatrixXd fixed;  ///< rows x 3
};

/// With order 1 the rows are those of the vertices that move alone.
Split split_columns(const Strip& strip, const std::vector<int>& unknown, int unknowns, int order) {
  const EdgeWeights weights(strip);
  const std::vector<double> scales = row_scales(strip, unknown, order);
  const auto rows = order >= 2 ? static_cast<Eigen::Index>(unknown.size()) : unknowns;
  Split split;
  split.fixed = Eigen::MatrixXd::Zero(rows, 3);
  Columns moving(rows, unknowns, weights.size());
  std::vector<Weight> column;
  for (std::uint32_t v = 0; v < unknown.size(); ++v) {
    weights.take_column(v, column);
    const Vec3 p = strip.positions[v];
    for (const Weight& entry : column) {
      if (scales[entry.neighbor] == 0.0) continue;
      const int row = order >= 2 ? static_cast<int>(entry.neighbor) : unknown[entry.neighbor];
      const double value = scales[entry.neighbor] * entry.weight;
      if (unknown[v] >= 0)
        moving.add(row, value);
      else
        split.fixed.row(row) += value * Eigen::RowVector3d(p.x, p.y, p.z);
    }
    if (unknown[v] >= 0) moving.end_column();
  }
  split.moving = moving.matrix();
  return split;
}

/// A system of least energy: `matrix` times the places of the unknowns is `right`.
struct Energy {
  Sparse half;    ///< order 2: the matrix is the square of this one
  Sparse matrix;  ///< order 1
  Eigen::MatrixXd right;

  Eigen::MatrixXd times(const Eigen::MatrixXd& x) const {
    if (half.rows() == 0) return matrix * x;
    const Eigen::MatrixXd product = half * x;
    return half.transpose() * product;
  }
  Eigen::VectorXd diagonal() const {
    if (half.rows() == 0) return matrix.diagonal();
    Eigen::VectorXd squares(half.cols());
    for (Eigen::Index column = 0; column < half.cols(); ++column)
      squares[column] = half.col(column).squaredNorm();
    return squares;
  }
};

Energy energy_of(const Strip& strip, const std::vector<int>& unknown, int unknowns, int order) {
  Split split = split_columns(strip, unknown, unknowns, order);
  Energy energy;
  if (order >= 2) {
    energy.half.swap(split.moving);
    energy.right = -(energy.half.transpose() * split.fixed);
    return energy;
  }
  energy.matrix.swap(split.moving);
  energy.right = -split.fixed;
  return energy;
}

/// The lower triangle of the square of a matrix: its transpose times itself.
Sparse lower_square(const Sparse& half) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> by_rows = half;
  Columns lower(half.cols(), half.cols(), 12 * static_cast<std::size_t>(half.cols()));
  std::vector<double> sums(static_cast<std::size_t>(half.cols()), 0.0);
  std::vector<int> last(static_cast<std::size_t>(half.cols()), -1), touched;
  for (int j = 0; j < half.cols(); ++j) {
    touched.clear();
    for (Sparse::InnerIterator of_j(half, j); of_j; ++of_j) {
      const int* columns = by_rows.innerIndexPtr();
      const int end = by_rows.outerIndexPtr()[of_j.row() + 1];
      for (int at = end - 1; at >= by_rows.outerIndexPtr()[of_j.row()] && columns[at] >= j; --at) {
        const int i = columns[at];
        const double product = by_rows.valuePtr()[at] * of_j.value();
        sums[i] = last[i] == j ? sums[i] + product : product;
        if (last[i] != j) touched.push_back(i);
        last[i] = j;
      }
    }
    std::sort(touched.begin(), touched.end());
    for (const int i : touched) lower.add(i, sums[i]);
    lower.end_column();
  }
  return lower.matrix();
}

/// The order of Eigen's AMDOrdering, for a matrix that is symmetric as it is.
struct SymmetricOrdering {
  using PermutationType = Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int>;
  void operator()(const Sparse& matrix, PermutationType& permutation) const {
    Eigen::AMDOrdering<int>()(matrix.selfadjointView<Eigen::Lower>(), permutation);
  }
};

/// Exactly; empty where the system is singular. n^1.5 at best.
Eigen::MatrixXd solved(const Energy& energy) {
  const Sparse matrix = energy.half.rows() == 0 ? energy.matrix : lower_square(energy.half);
  const Eigen::SimplicialLDLT<Sparse, Eigen::Lower, SymmetricOrdering> solver(matrix);
  if (solver.info() != Eigen::Success) return {};
  return solver.solve(energy.right);
}

/// From `places` on by steps of conjugate gradients, scaled by the diagonal (Hestenes, Stiefel
/// 1952; Shewchuk: An Introduction to the Conjugate Gradient Method, 1994, algorithm B3). What is
/// wrong over many edges stays so: that is for the coarser discs before.
Eigen::MatrixXd relaxed(const Energy& energy, Eigen::MatrixXd places) {
  constexpr int kSteps = 40;
  const Eigen::VectorXd scale = energy.diagonal().cwiseInverse();
  Eigen::MatrixXd residual = energy.right - energy.times(places);
  Eigen::MatrixXd scaled = scale.asDiagonal() * residual;
  Eigen::MatrixXd direction = scaled;
  Eigen::RowVectorXd length = residual.cwiseProduct(scaled).colwise().sum();
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::MatrixXd product = energy.times(direction);
    const Eigen::RowVectorXd bent = direction.cwiseProduct(product).colwise().sum();
    Eigen::RowVectorXd share = length.cwiseQuotient(bent);
    for (Eigen::Index k = 0; k < share.size(); ++k)
      if (!(bent[k] > 0.0)) share[k] = 0.0;
    places += direction * share.asDiagonal();
    residual -= product * share.asDiagonal();
    scaled = scale.asDiagonal() * residual;
    const Eigen::RowVectorXd next = residual.cwiseProduct(scaled).colwise().sum();
    Eigen::RowVectorXd kept = next.cwiseQuotient(length);
    for (Eigen::Index k = 0; k < kept.size(); ++k)
      if (!(length[k] > 0.0)) kept[k] = 0.0;
    direction = scaled + direction * kept.asDiagonal();
    length = next;
  }
  return places;
}

/// As `energy_of`, solved at once for a few unknowns: building sparse matrices would take most of
/// the time. Empty where the system is singular.
Eigen::MatrixXd solved_densely(const Strip& strip, const std::vector<int>& unknown, int unknowns,
                               int order) {
  std::vector<int> row(unknown.begin(), unknown.end());
  int rows = unknowns;
  if (order >= 2)
    for (std::size_t v = 0; v < strip.is_whole.size(); ++v)
      if (strip.is_whole[v] != 0 && row[v] < 0) row[v] = rows++;
  // Rows of the Laplacian: columns that move, and the others times where they are.
  Eigen::MatrixXd moving = Eigen::MatrixXd::Zero(rows, unknowns);
  Eigen::MatrixXd fixed = Eigen::MatrixXd::Zero(rows, 3);
  const auto add = [&](int at, std::uint32_t vertex, double weight) {
    if (unknown[vertex] >= 0) {
      moving(at, unknown[vertex]) += weight;
    } else {
      const Vec3 p = strip.positions[vertex];
      fixed.row(at) += weight * Eigen::RowVector3d(p.x, p.y, p.z);
    }
  };
  for (const CornerTriangle& t : strip.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[(k + 1) % 3], b = t[(k + 2) % 3];
      if (row[a] < 0 && row[b] < 0) continue;
      const double weight =
          half_cotangent(strip.positions[t[k]], strip.positions[a], strip.positions[b]);
      for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
        if (row[from] < 0) continue;
        add(row[from], to, weight);
        add(row[from], from, -weight);
      }
    }
  }
  if (order < 2) return (-moving).ldlt().solve(fixed);
  const std::vector<double> area = areas(strip);
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (row[v] < 0) continue;
    moving.row(row[v]) /= std::sqrt(area[v]);
    fixed.row(row[v]) /= std::sqrt(area[v]);
  }
  const Eigen::MatrixXd matrix = moving.transpose() * moving;
  return matrix.ldlt().solve(-(moving.transpose() * fixed));
}

/// Places of the unknowns; empty where there are none to be had.
Eigen::MatrixXd least_energy(const Strip& strip, const std::vector<int>& unknown, int unknowns,
                             int order) {
  constexpr int kMostExact = 3000;
  constexpr int kMostDense = 24;
  fix_block_sizes();
  if (unknowns <= kMostDense) {
    Eigen::MatrixXd places = solved_densely(strip, unknown, unknowns, order);
    return places.allFinite() ? places : Eigen::MatrixXd{};
  }
  const Energy energy = energy_of(strip, unknown, unknowns, order);
  Eigen::MatrixXd places(unknowns, 3);
  for (std::size_t v = 0; v < unknown.size(); ++v) {
    const Vec3 p = strip.positions[v];
    if (unknown[v] >= 0) places.row(unknown[v]) = Eigen::RowVector3d(p.x, p.y, p.z);
  }
  places = unknowns <= kMostExact ? solved(energy) : relaxed(energy, std::move(places));
  return places.allFinite() ? places : Eigen::MatrixXd{};
}

}  // namespace

void PatchMesh::smooth(int order, const RimSheet& sheet) {
  if (corners_ == 0 || mesh_.size() == 0) return;
  Strip strip{positions_, triangles(), sheet.is_whole};
  strip.is_whole.resize(corners_, 0);
  const std::uint32_t first = size() - corners_;
  strip.positions.insert(strip.positions.end(), sheet.positions.begin(), sheet.positions.end());
  for (CornerTriangle t : sheet.triangles) {
    for (std::uint32_t& v : t) v += v < corners_ ? 0 : first;
    strip.triangles.push_back(t);
  }
  const Vec3 center = positions_[0];  // so that coordinates far from the origin lose nothing
  for (Vec3& p : strip.positions) p = p - center;
  std::vector<int> unknown(strip.positions.size(), -1);
  int unknowns = 0;
  for (std::uint32_t v = corners_; v < size(); ++v) {
    if (mesh_.from[v] != kNone32) unknown[v] = unknowns++;
  }
  if (unknowns == 0) return;
  const Eigen::MatrixXd places = least_energy(strip, unknown, unknowns, order);
  if (places.rows() == 0) return;
  for (std::uint32_t v = corners_; v < size(); ++v) {
    if (unknown[v] < 0) continue;
    const auto row = places.row(unknown[v]);
    positions_[v] = center + Vec3{row[0], row[1], row[2]};
  }
}

}  // namespace orbweave
