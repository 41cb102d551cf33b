// What the hole pass asks of a mesh: in core it is looked up, in the pipeline it is read from the
// chunk store as it is needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/triangle_marks.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// A stitched mesh, by vertex number in canonical order. Safe to ask from many threads.
class Surface {
 public:
  virtual ~Surface() = default;
  virtual Vec3 position(std::uint64_t vertex) const = 0;
  /// Whether nothing is read from a file: what is said to ascend below may have any order then.
  virtual bool is_at_hand() const { return false; }
  /// All triangles at a vertex, smallest vertex first, sorted.
  virtual void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const = 0;
  /// The positions of many vertices, which ascend, at once; `out` is as long as `vertices`.
  virtual void positions(std::span<const std::uint64_t> vertices, std::span<Vec3> out) const {
    for (std::size_t i = 0; i < vertices.size(); ++i) out[i] = position(vertices[i]);
  }
  /// Adds the triangles at many vertices, which ascend, at once: those at one vertex after the
  /// other, in any order at each. `ends` gets out.size() after each vertex.
  virtual void triangles_at(std::span<const std::uint64_t> vertices, std::vector<Triangle64>& out,
                            std::vector<std::size_t>& ends) const {
    for (const std::uint64_t vertex : vertices) {
      triangles_at(vertex, out);
      ends.push_back(out.size());
    }
  }
  /// Adds the triangles at many vertices, which ascend, that were not met before, each once,
  /// smallest vertex first, in any order; they are marked.
  virtual void new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                                std::vector<Triangle64>& out) const {
    std::vector<Triangle64> around;
    for (const std::uint64_t vertex : vertices) {
      around.clear();
      triangles_at(vertex, around);
      for (const Triangle64& t : around)
        if (met.mark(t)) out.push_back(t);
    }
  }
  /// The vertices' attributes as doubles: vertices.size() rows of channels() values.
  virtual std::uint32_t channels() const = 0;
  virtual std::vector<double> values(std::span<const std::uint64_t> vertices) const = 0;
};

}  // namespace orbweave
