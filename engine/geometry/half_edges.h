// Triangles with their neighbours, as triangulations in the making need them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

inline constexpr std::uint32_t kNone32 = UINT32_MAX;

/// Half-edge h = 3 t + k runs from corner k of triangle t to its next corner.
struct HalfEdges {
  std::vector<std::uint32_t> origin;  ///< vertex at which the half-edge starts
  std::vector<std::uint32_t> twin;    ///< the same edge in the other triangle; kNone32: boundary
  std::vector<std::uint32_t> from;    ///< of every vertex one half-edge that starts there, or none

  static constexpr std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static constexpr std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
  std::uint32_t target(std::uint32_t h) const { return origin[next(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return origin[prev(h)]; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(origin.size()); }

  /// The next half-edge with the same origin, counter-clockwise or clockwise; kNone32 past the
  /// boundary.
  std::uint32_t left_of(std::uint32_t h) const { return twin[prev(h)]; }
  std::uint32_t right_of(std::uint32_t h) const {
    return twin[h] == kNone32 ? kNone32 : next(twin[h]);
  }
  /// The rightmost half-edge of the fan of h at its origin; h itself where the fan is closed.
  std::uint32_t first_of_fan(std::uint32_t h) const;

  void link(std::uint32_t h, std::uint32_t g);
  /// Appends an unlinked triangle; its first half-edge.
  std::uint32_t add(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  /// Rewrites a triangle; links stay as they are.
  void set(std::uint32_t triangle, std::uint32_t a, std::uint32_t b, std::uint32_t c);

  /// Turns the edge a-b of h with apexes c and d into c-d. h then runs from d to b and its twin
  /// from c to a; the new edge is prev(h), from c to d.
  void flip(std::uint32_t h);

  /// Puts a vertex into the triangle a b c of h, which becomes a b m; appends b c m and c a m and
  /// returns the half-edge b-c of the former.
  std::uint32_t split_triangle(std::uint32_t h, std::uint32_t vertex);
  /// Puts a vertex m onto the edge a-b of h with apexes c and d. h then runs from a to m and its
  /// twin back; appends m b c and b m d and returns the half-edge m-b.
  std::uint32_t split_edge(std::uint32_t h, std::uint32_t vertex);

  /// Links triangles by their edges. False where a directed edge occurs twice or a vertex is not
  /// below `vertices`.
  bool assign(std::span<const std::array<std::uint32_t, 3>> triangles, std::uint32_t vertices);

  /// Forgets triangles whose origins are kNone32; the others keep their order. No other triangle
  /// may be linked to them.
  void drop_removed();
};

}  // namespace orbweave
