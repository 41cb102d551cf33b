// Components of a mesh that comes in parts: triangles that are connected over edges, within a part
// and across parts. What is kept of a part are its edges of one triangle, until their other
// triangles come; memory is proportional to the boundaries of the parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/geometry/disjoint_sets.h"
#include "io/triangle_mesh.h"

namespace orbweave {

class EdgeComponents {
 public:
  /// The number in the whole mesh of a part's vertex.
  using GlobalVertex = std::function<std::uint64_t(std::uint32_t)>;

  /// Adds the next part of the mesh. No edge has triangles in more than two parts.
  void add(std::span<const Triangle> triangles, const GlobalVertex& global);
  /// After the last part: ranks the components by their triangles, the largest first; among equal
  /// ones that comes first whose first triangle was added first.
  void finish();

  /// Triangles of each component, by rank.
  const std::vector<std::uint64_t>& triangles() const { return triangles_; }
  /// Per triangle of a part, as it was added, the rank of its component.
  std::vector<std::uint32_t> ranks(std::size_t part, std::span<const Triangle> triangles) const;

 private:
  /// An edge of one triangle; vertices of the whole mesh.
  struct OpenEdge {
    std::uint64_t lower = 0, upper = 0;
    std::uint32_t component = 0;  ///< of all parts' components
    friend auto operator<=>(const OpenEdge&, const OpenEdge&) = default;
  };

  void join_open_edges();

  DisjointSets sets_{0};                  ///< of all parts' components
  std::vector<std::uint64_t> sizes_;      ///< theirs, in triangles
  std::vector<std::uint32_t> first_;      ///< per part: the number of its first component
  std::vector<std::uint32_t> rank_;       ///< per component of a part
  std::vector<std::uint64_t> triangles_;  ///< per rank
  std::vector<OpenEdge> open_;
  std::size_t join_at_ = 0;  ///< open edges
};

}  // namespace orbweave
