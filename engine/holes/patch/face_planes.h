// Planes that the faces of a piece of surface lie in, and how well they fit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// A face of a mesh.
struct PlacedFace {
  Vec3 center;
  Vec3 normal;  ///< unit
};

/// The points p with dot(normal, p) = offset.
struct FittedPlane {
  Vec3 normal;  ///< unit, as those of its faces
  double offset = 0.0;

  double distance(Vec3 p) const { return dot(normal, p) - offset; }  ///< signed
};

/// The line in which two planes meet.
struct CommonLine {
  Vec3 point;
  Vec3 direction;  ///< unit

  double place_of(Vec3 p) const { return dot(p - point, direction); }
  Vec3 at(double place) const { return point + place * direction; }
  double distance(Vec3 p) const { return norm(p - at(place_of(p))); }
};

/// Precondition: the planes are not parallel.
CommonLine common_line(const FittedPlane& a, const FittedPlane& b);

/// Planes as the faces fall into them: first by their normals (spherical k-means, from splits along
/// the axis in which normals differ most), then by distance as well, with planes of least squares.
/// `scale`: a distance that counts as much as normals one unit apart. Empty where a plane would get
/// fewer than a few faces. The result follows from the faces and their order.
std::vector<FittedPlane> fit_planes(std::span<const PlacedFace> faces, std::size_t count,
                                    double scale);

/// The plane that a face belongs to.
std::size_t nearest_plane(std::span<const FittedPlane> planes, const PlacedFace& face,
                          double scale);

/// The faces that are nearer to a plane than to all edges between two of them by `margin`, a
/// distance along the plane. At an edge faces run from one plane to the other.
std::vector<PlacedFace> faces_off_edges(std::span<const FittedPlane> planes,
                                        std::span<const PlacedFace> faces, double margin);

/// Root mean square of the distances of the faces' centres from their nearest planes. The worst
/// twentieth is left out: a chimney is no part of the roof.
double distance_from_planes(std::span<const FittedPlane> planes, std::span<const PlacedFace> faces);

/// Likewise, from a smooth surface: the heights over the mean plane that a polynomial of degree two
/// fits best. Infinite where there is none.
double distance_from_quadric(std::span<const PlacedFace> faces);

}  // namespace orbweave
