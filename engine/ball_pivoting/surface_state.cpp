#include "engine/ball_pivoting/surface_state.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::uint32_t kBlockPoints = 8192;

Triangle triangle_of(std::uint32_t vertex, Corner c) {
  return smallest_first(Triangle{vertex, first_of(c), second_of(c)});
}

std::uint32_t blocks_of(std::size_t points) {
  return static_cast<std::uint32_t>((points + kBlockPoints - 1) / kBlockPoints);
}

/// Runs visit(vertex, out) over all points in blocks and returns the outputs in order.
template <class T, class Visit>
std::vector<T> gather_over_points(std::size_t points, const StopToken* stop, const Visit& visit) {
  std::vector<std::vector<T>> parts(blocks_of(points));
  tbb::parallel_for(std::uint32_t{0}, blocks_of(points), [&](std::uint32_t block) {
    check_stop(stop);
    const std::uint32_t begin = block * kBlockPoints;
    const auto end = static_cast<std::uint32_t>(
        std::min<std::size_t>(points, std::size_t{begin} + kBlockPoints));
    for (std::uint32_t vertex = begin; vertex < end; ++vertex) visit(vertex, parts[block]);
  });
  std::vector<std::size_t> offsets(parts.size() + 1, 0);
  for (std::size_t b = 0; b < parts.size(); ++b) offsets[b + 1] = offsets[b] + parts[b].size();
  std::vector<T> all(offsets.back());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t b) {
    std::copy(parts[b].begin(), parts[b].end(),
              all.begin() + static_cast<std::ptrdiff_t>(offsets[b]));
    parts[b] = {};
  });
  return all;
}

/// The part of a list sorted by vertex that belongs to one vertex.
std::span<const VertexCorner> corners_at(std::span<const VertexCorner> sorted,
                                         std::uint32_t vertex) {
  const auto by_vertex = [](const VertexCorner& a, const VertexCorner& b) {
    return a.vertex < b.vertex;
  };
  const auto [first, last] =
      std::equal_range(sorted.begin(), sorted.end(), VertexCorner{vertex, 0}, by_vertex);
  return {first, last};
}

/// Calls visit(corners) for the corners of each vertex of a list sorted by vertex.
template <class Visit>
void for_each_vertex(std::span<const VertexCorner> sorted, const Visit& visit) {
  for (std::size_t i = 0, end = 0; i < sorted.size(); i = end) {
    for (end = i; end < sorted.size() && sorted[end].vertex == sorted[i].vertex;) ++end;
    visit(sorted.subspan(i, end - i));
  }
}

void sort_unique(std::vector<VertexCorner>& list) {
  tbb::parallel_sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

FanShape fan_shape(std::span<const VertexCorner> corners) {
  FanShape shape;
  const std::size_t n = corners.size();
  shape.label.assign(n, 0);
  std::vector<std::uint8_t> seen(n, 0);
  const auto follower = [&](std::size_t i) {
    for (std::size_t k = 0; k < n; ++k) {
      if (first_of(corners[k].corner) == second_of(corners[i].corner)) return k;
    }
    return n;
  };
  // Labels the fan that begins at corner i; returns its last corner.
  const auto follow = [&](std::size_t i) {
    ++shape.fans;
    std::vector<std::size_t> members;
    std::uint32_t label = first_of(corners[i].corner);
    for (; i < n && seen[i] == 0; i = follower(i)) {
      seen[i] = 1;
      label = std::min(label, first_of(corners[i].corner));
      members.push_back(i);
    }
    for (const std::size_t member : members) shape.label[member] = label;
    return members.back();
  };
  // Open fans begin at a corner that no other corner leads to; the remaining fans are cycles.
  std::vector<std::uint8_t> led_to(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t k = follower(i);
    if (k < n) led_to[k] = 1;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (led_to[i] != 0) continue;
    const std::size_t last = follow(i);
    shape.open.push_back(
        {second_of(corners[last].corner), corners[i].vertex, first_of(corners[i].corner)});
  }
  shape.closed = n > 0 && shape.fans == 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (seen[i] == 0) follow(i);
  }
  return shape;
}

SurfaceState::SurfaceState(RivalContext context, std::span<const std::uint8_t> owned,
                           const StopToken* stop)
    : context_(context),
      owned_(owned),
      stop_(stop),
      open_(context.local.size(), 1),
      unfinished_(context.local.size(), 1),
      fan_counts_(context.local.size(), 0) {}

/// Triangles that a walk at another of their vertices found, but the walk here did not.
std::vector<VertexCorner> SurfaceState::corners_found_elsewhere(const FanTable& fans) const {
  auto list = gather_over_points<VertexCorner>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<VertexCorner>& out) {
        for (const Corner c : fans.at(vertex)) {
          const std::uint32_t i = first_of(c), j = second_of(c);
          const Corner at_i = make_corner(j, vertex), at_j = make_corner(vertex, i);
          if (!fans.contains(i, at_i)) out.push_back({i, at_i});
          if (!fans.contains(j, at_j)) out.push_back({j, at_j});
        }
      });
  sort_unique(list);
  return list;
}

/// Losers of the conflict rule, smallest vertex first, sorted. Every directed edge is judged at
/// its tail; a closed fan to which nothing was added has no rivals.
std::vector<Triangle> SurfaceState::first_level_losers(
    const FanTable& fans, std::span<const VertexCorner> elsewhere) const {
  auto losers = gather_over_points<Triangle>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<Triangle>& out) {
        const auto added = corners_at(elsewhere, vertex);
        if (added.empty() && fans.closed(vertex)) return;
        std::vector<Corner> all(fans.at(vertex).begin(), fans.at(vertex).end());
        for (const VertexCorner& c : added) all.push_back(c.corner);
        std::sort(all.begin(), all.end());
        std::vector<Triangle> rivals;
        for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
          rivals.clear();
          for (end = i; end < all.size() && first_of(all[end]) == first_of(all[i]); ++end) {
            rivals.push_back(triangle_of(vertex, all[end]));
          }
          if (rivals.size() < 2) continue;
          const std::size_t best = best_rival(context_, rivals);
          for (std::size_t r = 0; r < rivals.size(); ++r) {
            if (r != best) out.push_back(rivals[r]);
          }
        }
      });
  tbb::parallel_sort(losers.begin(), losers.end());
  losers.erase(std::unique(losers.begin(), losers.end()), losers.end());
  return losers;
}

/// Settles one vertex: closed for good, or open with these corners.
void SurfaceState::close_or_keep(std::span<const VertexCorner> corners) {
  if (corners.empty()) return;
  const std::uint32_t vertex = corners.front().vertex;
  const FanShape shape = fan_shape(corners);
  fan_counts_[vertex] = static_cast<std::uint8_t>(std::min(shape.fans, 255u));
  open_[vertex] = shape.closed ? 0 : 1;
  if (!shape.closed) open_corners_.insert(open_corners_.end(), corners.begin(), corners.end());
  if (shape.closed && shape.fans > 1) {
    pinched_corners_.insert(pinched_corners_.end(), corners.begin(), corners.end());
  }
}

void SurfaceState::emit_first_level(const FanTable& fans, std::span<const VertexCorner> elsewhere,
                                    std::span<const Triangle> losers) {
  triangles_ = gather_over_points<Triangle>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<Triangle>& out) {
        if (!is_owned(vertex)) return;
        const std::size_t first = out.size();
        const auto take = [&](Corner c) {
          if (first_of(c) > vertex && second_of(c) > vertex) {
            out.push_back({vertex, first_of(c), second_of(c)});
          }
        };
        for (const Corner c : fans.at(vertex)) take(c);
        if (!elsewhere.empty()) {
          for (const VertexCorner& c : corners_at(elsewhere, vertex)) take(c.corner);
        }
        const auto begin = out.begin() + static_cast<std::ptrdiff_t>(first);
        std::sort(begin, out.end());
        if (losers.empty()) return;
        out.erase(std::remove_if(begin, out.end(),
                                 [&](const Triangle& t) {
                                   return std::binary_search(losers.begin(), losers.end(), t);
                                 }),
                  out.end());
      });
}

void SurfaceState::take_first_level(const FanTable& fans) {
  const std::vector<VertexCorner> elsewhere = corners_found_elsewhere(fans);
  const std::vector<Triangle> losers = first_level_losers(fans, elsewhere);
  for (const Triangle& t : losers) conflicts_lost_ += is_owned(t[0]) ? 1 : 0;
  emit_first_level(fans, elsewhere, losers);

  // Points whose walk closed and that nothing was added to nor taken from are done.
  std::vector<std::uint8_t> touched(fans.points(), 0);
  for (const VertexCorner& c : elsewhere) touched[c.vertex] = 1;
  for (const Triangle& t : losers) touched[t[0]] = touched[t[1]] = touched[t[2]] = 1;
  const auto corners = gather_over_points<VertexCorner>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<VertexCorner>& out) {
        if (fans.closed(vertex) && touched[vertex] == 0) {
          open_[vertex] = 0;
          fan_counts_[vertex] = 1;
          return;
        }
        const std::size_t first = out.size();
        const auto take = [&](Corner c) {
          if (!std::binary_search(losers.begin(), losers.end(), triangle_of(vertex, c))) {
            out.push_back({vertex, c});
          }
        };
        for (const Corner c : fans.at(vertex)) take(c);
        for (const VertexCorner& c : corners_at(elsewhere, vertex)) take(c.corner);
        std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
      });
  for_each_vertex(corners,
                  [&](std::span<const VertexCorner> at_vertex) { close_or_keep(at_vertex); });
  for (std::uint32_t vertex = 0; vertex < unfinished_.size(); ++vertex)
    unfinished_[vertex] = fans.blocked(vertex) ? 0 : 1;
  find_unfinished();
}

/// Points that have closed are finished.
void SurfaceState::find_unfinished() {
  any_unfinished_ = false;
  for (std::size_t i = 0; i < open_.size(); ++i) {
    unfinished_[i] = unfinished_[i] != 0 && open_[i] != 0 ? 1 : 0;
    any_unfinished_ = any_unfinished_ || unfinished_[i] != 0;
  }
}

/// Whether an open point already has a triangle on the directed edge to `head`.
bool SurfaceState::edge_taken(std::uint32_t tail, std::uint32_t head) const {
  const auto at = std::lower_bound(open_corners_.begin(), open_corners_.end(),
                                   VertexCorner{tail, make_corner(head, 0)});
  return at != open_corners_.end() && at->vertex == tail && first_of(at->corner) == head;
}

void SurfaceState::take_level(const FanTable& fans) {
  auto found = gather_over_points<Triangle>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<Triangle>& out) {
        for (const Corner c : fans.at(vertex)) {
          const std::uint32_t i = first_of(c), j = second_of(c);
          if (edge_taken(vertex, i) || edge_taken(i, j) || edge_taken(j, vertex)) continue;
          out.push_back(triangle_of(vertex, c));
        }
      });
  tbb::parallel_sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  const std::vector<std::uint8_t> lost = find_losers(context_, found);

  std::vector<VertexCorner> corners = std::move(open_corners_);
  open_corners_.clear();
  const std::size_t emitted = triangles_.size();
  for (std::size_t t = 0; t < found.size(); ++t) {
    const auto [a, b, c] = found[t];
    if (lost[t] != 0) {
      conflicts_lost_ += is_owned(a) ? 1 : 0;
      continue;
    }
    if (is_owned(a)) triangles_.push_back(found[t]);
    corners.push_back({a, make_corner(b, c)});
    corners.push_back({b, make_corner(c, a)});
    corners.push_back({c, make_corner(a, b)});
  }
  for (std::uint32_t vertex = 0; vertex < unfinished_.size(); ++vertex)
    if (fans.blocked(vertex)) unfinished_[vertex] = 0;
  std::inplace_merge(triangles_.begin(), triangles_.begin() + static_cast<std::ptrdiff_t>(emitted),
                     triangles_.end());
  tbb::parallel_sort(corners.begin(), corners.end());
  for_each_vertex(corners,
                  [&](std::span<const VertexCorner> at_vertex) { close_or_keep(at_vertex); });
  find_unfinished();
}

/// A triangle that no other shares an edge with. Its vertices are open then.
bool SurfaceState::is_isolated(const Triangle& t) const {
  for (int k = 0; k < 3; ++k) {
    if (open_[t[k]] == 0 || edge_taken(t[(k + 1) % 3], t[k])) return false;
  }
  return true;
}

void SurfaceState::drop_isolated() {
  std::vector<Triangle> isolated;
  for (const VertexCorner& c : open_corners_) {
    const Triangle t{c.vertex, first_of(c.corner), second_of(c.corner)};
    if (!is_isolated(t)) continue;
    --fan_counts_[c.vertex];  // it was a fan of its own
    if (t == smallest_first(t)) isolated.push_back(t);
  }
  std::sort(isolated.begin(), isolated.end());
  for (const Triangle& t : isolated) isolated_dropped_ += is_owned(t[0]) ? 1 : 0;
  std::erase_if(triangles_, [&](const Triangle& t) {
    return std::binary_search(isolated.begin(), isolated.end(), t);
  });
  std::erase_if(open_corners_, [&](const VertexCorner& c) {
    return std::binary_search(isolated.begin(), isolated.end(), triangle_of(c.vertex, c.corner));
  });
}

void SurfaceState::describe(std::vector<BoundaryFan>& boundary,
                            std::vector<FanMember>& members) const {
  const auto visit = [&](std::span<const VertexCorner> corners) {
    for_each_vertex(corners, [&](std::span<const VertexCorner> at_vertex) {
      const FanShape shape = fan_shape(at_vertex);
      boundary.insert(boundary.end(), shape.open.begin(), shape.open.end());
      if (shape.fans < 2) return;
      for (std::size_t i = 0; i < at_vertex.size(); ++i) {
        members.push_back({at_vertex[i].vertex, first_of(at_vertex[i].corner), shape.label[i]});
      }
    });
  };
  visit(open_corners_);
  visit(pinched_corners_);
  std::sort(members.begin(), members.end());
}

}  // namespace orbweave
