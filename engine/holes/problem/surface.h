// What the hole pass asks of a mesh: in core it is looked up, in the pipeline it is read from the
// chunk store as it is needed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// A stitched mesh, by vertex number in canonical order. Safe to ask from many threads.
class Surface {
 public:
  virtual ~Surface() = default;
  virtual Vec3 position(std::uint64_t vertex) const = 0;
  /// All triangles at a vertex, smallest vertex first, sorted.
  virtual void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const = 0;
  /// The vertices' attributes as doubles: vertices.size() rows of channels() values.
  virtual std::uint32_t channels() const = 0;
  virtual std::vector<double> values(std::span<const std::uint64_t> vertices) const = 0;
};

}  // namespace orbweave
