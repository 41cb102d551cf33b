#include "engine/holes/patch/face_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/geometry/plane_axes.h"
#include "engine/geometry/symmetric_eigen.h"

namespace orbweave {
namespace {

constexpr std::size_t kLeastFaces = 6;  // of a plane

using Labels = std::vector<std::uint8_t>;

/// Faces with one label.
struct FaceGroup {
  std::size_t count = 0;
  Vec3 center;  ///< mean
  Vec3 normal;  ///< mean, not of unit length
};

FaceGroup group_of(std::span<const PlacedFace> faces, const Labels& labels, std::size_t label) {
  FaceGroup group;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (labels[i] != label) continue;
    ++group.count;
    group.center = group.center + faces[i].center;
    group.normal = group.normal + faces[i].normal;
  }
  if (group.count == 0) return group;
  group.center = group.center / static_cast<double>(group.count);
  group.normal = group.normal / static_cast<double>(group.count);
  return group;
}

/// How much the normals of a group differ, and along which axis most.
struct NormalSpread {
  double variance = 0.0;
  Vec3 axis;
};

NormalSpread spread_of(std::span<const PlacedFace> faces, const Labels& labels, std::size_t label) {
  const FaceGroup group = group_of(faces, labels, label);
  SymmetricMatrix sum;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (labels[i] == label) sum += outer(faces[i].normal - group.normal);
  return {sum.xx + sum.yy + sum.zz, eigen_of(sum).vectors[2]};
}

/// Gives half of a group the new label: the faces whose normals lie beyond its mean along the axis
/// in which they differ most.
void split(std::span<const PlacedFace> faces, std::size_t label, std::size_t new_label,
           Labels& labels) {
  const Vec3 mean = group_of(faces, labels, label).normal;
  const Vec3 axis = spread_of(faces, labels, label).axis;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (labels[i] == label && dot(faces[i].normal - mean, axis) > 0.0)
      labels[i] = static_cast<std::uint8_t>(new_label);
}

/// The means of the groups' normals, of unit length.
void means_of_normals(std::span<const PlacedFace> faces, const Labels& labels,
                      std::vector<Vec3>& means) {
  std::vector<std::size_t> counts(means.size(), 0);
  std::fill(means.begin(), means.end(), Vec3{});
  for (std::size_t i = 0; i < faces.size(); ++i) {
    ++counts[labels[i]];
    means[labels[i]] = means[labels[i]] + faces[i].normal;
  }
  for (std::size_t label = 0; label < means.size(); ++label)
    if (counts[label] > 0)
      means[label] = normalized(means[label] / static_cast<double>(counts[label]));
}

/// Rounds of k-means on the sphere of normals. One that changes nothing is the last.
void gather_by_normals(std::span<const PlacedFace> faces, std::size_t count, Labels& labels) {
  constexpr int kRounds = 8;
  std::vector<Vec3> means(count);
  bool has_changed = true;
  for (int round = 0; round < kRounds && has_changed; ++round) {
    means_of_normals(faces, labels, means);
    has_changed = false;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      double most = dot(faces[i].normal, means[labels[i]]);
      for (std::size_t label = 0; label < count; ++label) {
        const double cosine = dot(faces[i].normal, means[label]);
        if (!(cosine > most)) continue;
        most = cosine;
        labels[i] = static_cast<std::uint8_t>(label);
        has_changed = true;
      }
    }
  }
}

/// Of least squares, through the faces with a label.
FittedPlane plane_of(std::span<const PlacedFace> faces, const Labels& labels, std::size_t label) {
  const FaceGroup group = group_of(faces, labels, label);
  SymmetricMatrix sum;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if (labels[i] == label) sum += outer(faces[i].center - group.center);
  Vec3 normal = eigen_of(sum).vectors[0];
  if (dot(normal, group.normal) < 0.0) normal = -normal;
  return {normal, dot(normal, group.center)};
}

/// The group whose normals differ most.
std::size_t widest_group(std::span<const PlacedFace> faces, std::size_t count,
                         const Labels& labels) {
  std::size_t widest = 0;
  double most = -1.0;
  for (std::size_t label = 0; label < count; ++label) {
    const double variance = spread_of(faces, labels, label).variance;
    if (variance <= most) continue;
    most = variance;
    widest = label;
  }
  return widest;
}

bool has_few(std::span<const PlacedFace> faces, std::size_t count, const Labels& labels) {
  std::vector<std::size_t> counts(count, 0);
  for (std::size_t i = 0; i < faces.size(); ++i) ++counts[labels[i]];
  return std::any_of(counts.begin(), counts.end(),
                     [](std::size_t faces_of_one) { return faces_of_one < kLeastFaces; });
}

double rms_of_best(std::vector<double> squares) {
  if (squares.empty()) return std::numeric_limits<double>::infinity();
  const std::size_t kept = squares.size() - squares.size() / 20;
  std::ranges::sort(squares);
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += squares[i];
  return std::sqrt(sum / static_cast<double>(kept));
}

constexpr std::size_t kTerms = 6;
using Terms = std::array<double, kTerms>;

/// Solves the normal equations of least squares in place, by Cholesky's method; false where they
/// are singular.
bool solve(std::array<Terms, kTerms>& matrix, Terms& right) {
  for (std::size_t j = 0; j < kTerms; ++j) {
    double pivot = matrix[j][j];
    const double whole = pivot;
    for (std::size_t k = 0; k < j; ++k) pivot -= matrix[j][k] * matrix[j][k];
    constexpr double kSingular = 1e-12;  // of the entry that it was
    if (!(pivot > kSingular * whole)) return false;
    matrix[j][j] = std::sqrt(pivot);
    for (std::size_t i = j + 1; i < kTerms; ++i) {
      double sum = matrix[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
      matrix[i][j] = sum / matrix[j][j];
    }
  }
  for (std::size_t i = 0; i < kTerms; ++i) {
    for (std::size_t k = 0; k < i; ++k) right[i] -= matrix[i][k] * right[k];
    right[i] /= matrix[i][i];
  }
  for (std::size_t i = kTerms; i-- > 0;) {
    for (std::size_t k = i + 1; k < kTerms; ++k) right[i] -= matrix[k][i] * right[k];
    right[i] /= matrix[i][i];
  }
  return true;
}

double value_of(const Terms& polynomial, const Terms& terms) {
  double sum = 0.0;
  for (std::size_t k = 0; k < kTerms; ++k) sum += polynomial[k] * terms[k];
  return sum;
}

}  // namespace

CommonLine common_line(const FittedPlane& a, const FittedPlane& b) {
  const Vec3 along = cross(a.normal, b.normal);
  const Vec3 point =
      (a.offset * cross(b.normal, along) + b.offset * cross(along, a.normal)) / squared_norm(along);
  return {point, normalized(along)};
}

std::vector<FittedPlane> fit_planes(std::span<const PlacedFace> faces, std::size_t count,
                                    double scale) {
  constexpr int kRounds = 4;
  Labels labels(faces.size(), 0);
  for (std::size_t groups = 1; groups < count; ++groups) {
    split(faces, widest_group(faces, groups, labels), groups, labels);
    gather_by_normals(faces, groups + 1, labels);
  }
  std::vector<FittedPlane> planes;
  bool has_changed = true;
  for (int round = 0; round < kRounds && has_changed; ++round) {
    if (has_few(faces, count, labels)) return {};
    planes.clear();
    for (std::size_t label = 0; label < count; ++label)
      planes.push_back(plane_of(faces, labels, label));
    has_changed = false;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const auto nearest = static_cast<std::uint8_t>(nearest_plane(planes, faces[i], scale));
      has_changed = has_changed || nearest != labels[i];
      labels[i] = nearest;
    }
  }
  return planes;
}

std::size_t nearest_plane(std::span<const FittedPlane> planes, const PlacedFace& face,
                          double scale) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const double away = planes[i].distance(face.center);
    const double cost = away * away + scale * scale * squared_norm(face.normal - planes[i].normal);
    if (cost >= least) continue;
    least = cost;
    nearest = i;
  }
  return nearest;
}

std::vector<PlacedFace> faces_off_edges(std::span<const FittedPlane> planes,
                                        std::span<const PlacedFace> faces, double margin) {
  std::vector<PlacedFace> kept;
  for (const PlacedFace& face : faces) {
    std::size_t own = 0;
    for (std::size_t i = 1; i < planes.size(); ++i)
      if (std::abs(planes[i].distance(face.center)) < std::abs(planes[own].distance(face.center)))
        own = i;
    bool at_edge = false;
    for (std::size_t i = 0; i < planes.size() && !at_edge; ++i) {
      const double sine = norm(cross(planes[i].normal, planes[own].normal));
      at_edge = i != own && std::abs(planes[i].distance(face.center)) < margin * sine;
    }
    if (!at_edge) kept.push_back(face);
  }
  return kept;
}

double distance_from_planes(std::span<const FittedPlane> planes,
                            std::span<const PlacedFace> faces) {
  std::vector<double> squares;
  squares.reserve(faces.size());
  for (const PlacedFace& face : faces) {
    double least = std::numeric_limits<double>::infinity();
    for (const FittedPlane& plane : planes)
      least = std::min(least, plane.distance(face.center) * plane.distance(face.center));
    squares.push_back(least);
  }
  return rms_of_best(std::move(squares));
}

double distance_from_quadric(std::span<const PlacedFace> faces) {
  const FaceGroup all = group_of(faces, Labels(faces.size(), 0), 0);
  double reach = 0.0;
  for (const PlacedFace& face : faces) reach = std::max(reach, norm(face.center - all.center));
  const Vec3 up = normalized(all.normal);
  if (!(reach > 0.0) || !(squared_norm(up) > 0.0)) return std::numeric_limits<double>::infinity();
  const PlaneAxes axes = plane_axes(up);
  std::vector<Terms> rows;
  std::array<Terms, kTerms> matrix{};
  Terms polynomial{};
  for (const PlacedFace& face : faces) {
    const Vec3 p = (face.center - all.center) / reach;
    const double u = dot(p, axes.u), v = dot(p, axes.v), height = dot(p, up);
    const Terms& row = rows.emplace_back(Terms{1.0, u, v, u * u, u * v, v * v});
    for (std::size_t i = 0; i < kTerms; ++i) {
      for (std::size_t k = 0; k <= i; ++k) matrix[i][k] += row[i] * row[k];
      polynomial[i] += row[i] * height;
    }
  }
  if (!solve(matrix, polynomial)) return std::numeric_limits<double>::infinity();
  std::vector<double> squares;
  squares.reserve(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double height = dot(faces[i].center - all.center, up) / reach;
    const double off = height - value_of(polynomial, rows[i]);
    squares.push_back(off * off);
  }
  return reach * rms_of_best(std::move(squares));
}

}  // namespace orbweave
