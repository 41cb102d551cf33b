// Discs cut out of meshes, so that what a fill puts there can be measured against what was there.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave::bench {

/// What cutting asks of a mesh: triangles at vertices, which vertices lie inside, how far apart.
class MeshIndex {
 public:
  explicit MeshIndex(const TriangleMesh& mesh);
  const TriangleMesh& mesh() const { return mesh_; }
  std::span<const std::uint32_t> triangles_at(std::uint32_t vertex) const;
  /// Scanned vertices whose triangles make one closed fan.
  bool is_inner(std::uint32_t vertex) const { return inner_[vertex]; }
  /// In the component of the most triangles.
  bool in_main_component(std::uint32_t vertex) const { return main_[vertex]; }
  /// True where a face of the scan, not of a patch, uses the vertex.
  bool is_scanned(std::uint32_t vertex) const { return scanned_[vertex]; }
  double spacing() const { return spacing_; }  ///< mean edge length, world units
  const std::vector<Vec3>& normals() const { return normals_; }

 private:
  bool has_closed_fan(std::uint32_t vertex) const;
  void find_main_component();

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> items_;
  std::vector<bool> inner_, main_, scanned_;
  std::vector<Vec3> normals_;
  double spacing_ = 0.0;
};

/// Vertices that are joined to the centre by edges between vertices within a radius of it.
struct Disc {
  std::uint32_t center = 0;
  std::vector<std::uint32_t> removed;  ///< vertices, ascending
  std::vector<std::uint32_t> faces;    ///< that use one of them, ascending
  std::vector<std::uint32_t> rim;      ///< in the direction in which a patch uses its edges
};

/// The disc of a radius (world units) around a vertex, when it is clean: its faces make a
/// topological disc with a simple rim, and no vertex of it is on a border or has several fans.
std::optional<Disc> clean_disc(const MeshIndex& index, std::uint32_t center, double radius);

/// The vertices connected to `center` within `reach` of it, ascending.
std::vector<std::uint32_t> connected_within(const MeshIndex& index, std::uint32_t center,
                                            double reach);

/// A part of a mesh without some of its triangles.
struct Cut {
  TriangleMesh mesh;                    ///< positions and triangles only
  std::vector<std::uint32_t> vertices;  ///< ascending: vertex i was vertices[i]
  /// The number here of a vertex that is there.
  std::uint32_t number_of(std::uint32_t vertex) const;
};

/// The triangles whose vertices are all in `vertices` (ascending), without `without` (ascending).
/// Vertices that no triangle is left to use go.
Cut cut_part(const MeshIndex& index, std::span<const std::uint32_t> vertices,
             std::span<const std::uint32_t> without);
/// The triangles with a vertex within `reach` of a place, on whatever sheet, without `without`.
Cut cut_ball(const MeshIndex& index, Vec3 place, double reach,
             std::span<const std::uint32_t> without);

}  // namespace orbweave::bench
