// Boundary loops: closed cycles of edges with one triangle, traced from the fans at their vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// An open fan as it lies at its vertex: the boundary runs previous -> vertex -> next along the
/// directions of the fan's own triangles.
struct OpenFan {
  std::uint64_t previous = 0;
  std::uint64_t vertex = 0;
  std::uint64_t next = 0;
  std::uint64_t component = 0;  ///< any label of the connected piece that the fan belongs to
  friend auto operator<=>(const OpenFan&, const OpenFan&) = default;
};

/// A boundary vertex.
struct BoundaryVertex {
  std::uint64_t vertex = 0;
  Vec3 position;
  Vec3 normal;  ///< any length; zero: unknown
};

struct BoundaryLoop {
  /// Vertices in the direction in which a patch uses the edges (against the fans' triangles), from
  /// the smallest on. A loop that touches itself visits a vertex several times.
  std::vector<std::uint64_t> vertices;
  std::vector<std::uint64_t> components;  ///< labels of the pieces along it, sorted, unique
  double perimeter = 0.0;
  double radius = 0.0;  ///< of the ball around `center`
  Vec3 center;          ///< mean of the loop's vertices
  Vec3 area_vector;     ///< half the sum of cross products of successive vertices about `center`
  Vec3 mean_normal;     ///< mean of the unit vertex normals along the loop
  /// Cosine between the area vector and the mean of the normals, times the latter's length: near
  /// 1 for a hole in a smooth surface, near -1 for the outer border of a sheet, about 0 where the
  /// surface ends like a tube.
  double agreement() const { return dot(normalized(area_vector), mean_normal); }
};

/// Joins the fans to loops. Where several fans meet at a vertex and lie beside one another around
/// its normal, the loops pass from a fan to the next one around (so that filling them makes one
/// fan of all); where fans overlap, as those of two sheets that touch do, each loop stays on its
/// fan. `vertices` sorted by number, one per boundary vertex. The loops come in canonical order:
/// by their vertices. Fans whose edges end nowhere (a non-manifold edge) are left out.
/// O(n log n); memory about 150 bytes per fan. `stop`, which may be null, is looked at several
/// times a second.
std::vector<BoundaryLoop> trace_loops(std::vector<OpenFan> fans,
                                      std::span<const BoundaryVertex> vertices,
                                      const StopToken* stop = nullptr);

/// Turns the vertices of a loop so that the canonical one is first, and brings its measures up to
/// date; `components` stay. `vertices` as for trace_loops(). `stop` may be null.
void measure_loop(std::span<const BoundaryVertex> vertices, BoundaryLoop& loop,
                  const StopToken* stop = nullptr);

}  // namespace orbweave
