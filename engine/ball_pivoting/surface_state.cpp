#include "engine/ball_pivoting/surface_state.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "io/first_touch.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kBlockPoints = 8192;

Triangle triangle_of(std::uint32_t vertex, Corner c) {
  return smallest_first(Triangle{vertex, first_of(c), second_of(c)});
}

std::uint32_t blocks_of(std::size_t points) {
  return static_cast<std::uint32_t>((points + kBlockPoints - 1) / kBlockPoints);
}

/// The parts one after the other.
template <class T>
std::vector<T> joined(std::vector<std::vector<T>> parts) {
  std::vector<std::size_t> offsets(parts.size() + 1, 0);
  for (std::size_t b = 0; b < parts.size(); ++b) offsets[b + 1] = offsets[b] + parts[b].size();
  std::vector<T> all;
  reserve_touched(all, offsets.back());
  all.resize(offsets.back());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t b) {
    std::copy(parts[b].begin(), parts[b].end(),
              all.begin() + static_cast<std::ptrdiff_t>(offsets[b]));
    parts[b] = {};
  });
  return all;
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
  return joined(std::move(parts));
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

/// Where the corners of a vertex begin, at or after a place of a list sorted by vertex.
std::size_t vertex_begin(std::span<const VertexCorner> sorted, std::size_t at) {
  if (at >= sorted.size()) return sorted.size();
  while (at > 0 && at < sorted.size() && sorted[at].vertex == sorted[at - 1].vertex) ++at;
  return at;
}

/// Runs visit(corners, out) for the corners of each vertex of a list sorted by vertex, in blocks,
/// and returns the blocks' outputs in order.
template <class Out, class Visit>
std::vector<Out> gather_over_fans(std::span<const VertexCorner> sorted, const StopToken* stop,
                                  const Visit& visit) {
  std::vector<Out> parts(blocks_of(sorted.size()));
  tbb::parallel_for(std::uint32_t{0}, blocks_of(sorted.size()), [&](std::uint32_t block) {
    check_stop(stop);
    const std::size_t last = vertex_begin(sorted, (std::size_t{block} + 1) * kBlockPoints);
    for (std::size_t i = vertex_begin(sorted, std::size_t{block} * kBlockPoints), end = i; i < last;
         i = end) {
      while (end < sorted.size() && sorted[end].vertex == sorted[i].vertex) ++end;
      visit(sorted.subspan(i, end - i), parts[block]);
    }
  });
  return parts;
}

/// One list of all parts: that which `member` names.
template <class T, class Part>
std::vector<T> joined(std::vector<Part>& parts, std::vector<T> Part::*member) {
  std::vector<std::vector<T>> lists;
  lists.reserve(parts.size());
  for (Part& part : parts) lists.push_back(std::move(part.*member));
  return joined(std::move(lists));
}

void sort_unique(std::vector<VertexCorner>& list) {
  tbb::parallel_sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Two sorted lists as one, in blocks of the longer.
std::vector<Triangle> merged(std::span<const Triangle> longer, std::span<const Triangle> shorter) {
  std::vector<Triangle> all;
  reserve_touched(all, longer.size() + shorter.size());
  all.resize(longer.size() + shorter.size());
  const std::uint32_t blocks = std::max(1u, blocks_of(longer.size()));
  const auto begin_of = [&](std::uint32_t block) {
    return std::min<std::size_t>(longer.size(), std::size_t{block} * kBlockPoints);
  };
  const auto begin_in_shorter = [&](std::uint32_t block) -> std::size_t {
    if (block == 0) return 0;
    if (block == blocks) return shorter.size();
    const auto at = std::lower_bound(shorter.begin(), shorter.end(), longer[begin_of(block)]);
    return static_cast<std::size_t>(at - shorter.begin());
  };
  tbb::parallel_for(std::uint32_t{0}, blocks, [&](std::uint32_t block) {
    const std::size_t from = begin_of(block), other = begin_in_shorter(block);
    const auto own = longer.subspan(from, begin_of(block + 1) - from);
    const auto beside = shorter.subspan(other, begin_in_shorter(block + 1) - other);
    std::merge(own.begin(), own.end(), beside.begin(), beside.end(),
               all.begin() + static_cast<std::ptrdiff_t>(from + other));
  });
  return all;
}

/// Takes the members of one sorted list out of another.
template <class T>
void remove_sorted(std::span<const T> taken, std::vector<T>& list) {
  if (taken.empty()) return;
  auto next = taken.begin();
  auto kept = std::lower_bound(list.begin(), list.end(), taken.front());
  for (auto at = kept; at != list.end(); ++at) {
    while (next != taken.end() && *next < *at) ++next;
    if (next == taken.end() || *at < *next) *kept++ = *at;
  }
  list.erase(kept, list.end());
}

}  // namespace

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

/// Settles the vertices of a list: each is closed for good, or open with its corners.
void SurfaceState::close_or_keep(std::span<const VertexCorner> sorted) {
  struct Settled {
    FanFinder finder;
    std::vector<VertexCorner> open, pinched;
  };
  auto parts = gather_over_fans<Settled>(
      sorted, stop_, [this](std::span<const VertexCorner> corners, Settled& out) {
        const std::uint32_t vertex = corners.front().vertex;
        const FanShape& shape = out.finder.shape_of(corners);
        fan_counts_[vertex] = static_cast<std::uint8_t>(std::min(shape.fans, 255u));
        open_[vertex] = shape.closed ? 0 : 1;
        if (shape.closed && shape.fans < 2) return;
        std::vector<VertexCorner>& list = shape.closed ? out.pinched : out.open;
        list.insert(list.end(), corners.begin(), corners.end());
      });
  open_corners_ = joined(parts, &Settled::open);
  const std::vector<VertexCorner> pinched = joined(parts, &Settled::pinched);
  pinched_corners_.insert(pinched_corners_.end(), pinched.begin(), pinched.end());
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
  close_or_keep(corners);
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
  for (std::size_t t = 0; t < found.size(); ++t) {
    const auto [a, b, c] = found[t];
    if (lost[t] != 0) {
      conflicts_lost_ += is_owned(a) ? 1 : 0;
      continue;
    }
    if (is_owned(a)) later_triangles_.push_back(found[t]);
    corners.push_back({a, make_corner(b, c)});
    corners.push_back({b, make_corner(c, a)});
    corners.push_back({c, make_corner(a, b)});
  }
  for (std::uint32_t vertex = 0; vertex < unfinished_.size(); ++vertex)
    if (fans.blocked(vertex)) unfinished_[vertex] = 0;
  tbb::parallel_sort(corners.begin(), corners.end());
  close_or_keep(corners);
  find_unfinished();
}

/// A triangle that no other shares an edge with. Its vertices are open then.
bool SurfaceState::is_isolated(const Triangle& t) const {
  for (int k = 0; k < 3; ++k) {
    if (open_[t[k]] == 0 || edge_taken(t[(k + 1) % 3], t[k])) return false;
  }
  return true;
}

/// Corners of triangles that are isolated, sorted; all three of each, since all its vertices are
/// open.
std::vector<VertexCorner> SurfaceState::isolated_corners() const {
  auto parts = gather_over_fans<std::vector<VertexCorner>>(
      open_corners_, stop_,
      [this](std::span<const VertexCorner> corners, std::vector<VertexCorner>& out) {
        for (const VertexCorner& c : corners)
          if (is_isolated({c.vertex, first_of(c.corner), second_of(c.corner)})) out.push_back(c);
      });
  return joined(std::move(parts));
}

void SurfaceState::merge_levels() {
  tbb::parallel_sort(later_triangles_.begin(), later_triangles_.end());
  if (!later_triangles_.empty()) triangles_ = merged(triangles_, later_triangles_);
  later_triangles_ = {};
}

void SurfaceState::drop_isolated() {
  merge_levels();
  const std::vector<VertexCorner> corners = isolated_corners();
  std::vector<Triangle> isolated;  // sorted, as the corners at their smallest vertices are
  for (const VertexCorner& c : corners) {
    --fan_counts_[c.vertex];  // it was a fan of its own
    const Triangle t{c.vertex, first_of(c.corner), second_of(c.corner)};
    if (t == smallest_first(t)) isolated.push_back(t);
  }
  for (const Triangle& t : isolated) isolated_dropped_ += is_owned(t[0]) ? 1 : 0;
  remove_sorted<Triangle>(isolated, triangles_);
  remove_sorted<VertexCorner>(corners, open_corners_);
}

void SurfaceState::describe(std::vector<BoundaryFan>& boundary,
                            std::vector<FanMember>& members) const {
  struct Described {
    FanFinder finder;
    std::vector<BoundaryFan> boundary;
    std::vector<FanMember> members;
  };
  const auto describe_fan = [](std::span<const VertexCorner> corners, Described& out) {
    const FanShape& shape = out.finder.shape_of(corners);
    out.boundary.insert(out.boundary.end(), shape.open.begin(), shape.open.end());
    if (shape.fans < 2) return;
    for (std::size_t i = 0; i < corners.size(); ++i)
      out.members.push_back({corners[i].vertex, first_of(corners[i].corner), shape.label[i]});
  };
  auto parts = gather_over_fans<Described>(open_corners_, stop_, describe_fan);
  // Closed vertices have no open fans.
  for (Described& part : gather_over_fans<Described>(pinched_corners_, stop_, describe_fan))
    parts.push_back(std::move(part));
  boundary = joined(parts, &Described::boundary);
  members = joined(parts, &Described::members);
  tbb::parallel_sort(members.begin(), members.end());
}

}  // namespace orbweave
