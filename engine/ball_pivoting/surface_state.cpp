#include "engine/ball_pivoting/surface_state.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "io/first_touch.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kBlockPoints = 8192;

/// Room for the triangles of a block of points: a surface has two for each point.
constexpr std::size_t kBlockTriangles = 2 * kBlockPoints;

Triangle triangle_of(std::uint32_t vertex, Corner c) {
  return smallest_first(Triangle{vertex, first_of(c), second_of(c)});
}

std::uint32_t blocks_of(std::size_t points) {
  return static_cast<std::uint32_t>((points + kBlockPoints - 1) / kBlockPoints);
}

/// Where the lists of the parts begin in a list of all, and its size.
template <class Parts, class SizeOf>
std::vector<std::size_t> offsets_of(const Parts& parts, const SizeOf& size_of) {
  std::vector<std::size_t> offsets(parts.size() + 1, 0);
  for (std::size_t b = 0; b < parts.size(); ++b) offsets[b + 1] = offsets[b] + size_of(b);
  return offsets;
}

/// The parts one after the other.
template <class T>
std::vector<T> joined(std::vector<std::vector<T>> parts) {
  const std::vector<std::size_t> offsets =
      offsets_of(parts, [&](std::size_t b) { return parts[b].size(); });
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

/// Runs visit(vertex, out, scratch) over all points in blocks, each with a scratch of its own, and
/// returns the outputs in order.
template <class T, class Scratch, class Visit>
std::vector<std::vector<T>> gather_in_blocks(std::size_t points, const StopToken* stop,
                                             std::size_t room, const Visit& visit) {
  std::vector<std::vector<T>> parts(blocks_of(points));
  tbb::parallel_for(std::uint32_t{0}, blocks_of(points), [&](std::uint32_t block) {
    check_stop(stop);
    Scratch scratch;
    std::vector<T>& out = parts[block];
    out.reserve(room);
    const std::uint32_t begin = block * kBlockPoints;
    const auto end = static_cast<std::uint32_t>(
        std::min<std::size_t>(points, std::size_t{begin} + kBlockPoints));
    for (std::uint32_t vertex = begin; vertex < end; ++vertex) visit(vertex, out, scratch);
  });
  return parts;
}

/// As gather_in_blocks(), in one list.
template <class T, class Scratch, class Visit>
std::vector<T> gather_over_points(std::size_t points, const StopToken* stop, const Visit& visit) {
  return joined(gather_in_blocks<T, Scratch>(points, stop, 0, visit));
}

struct NoScratch {};

/// Looks up corners in a list sorted by vertex. The vertices that are asked for ascend.
class CornerLookup {
 public:
  std::span<const VertexCorner> at(std::span<const VertexCorner> sorted, std::uint32_t vertex) {
    if (!is_placed_) next_ = first_from(sorted, vertex);
    is_placed_ = true;
    while (next_ < sorted.size() && sorted[next_].vertex < vertex) ++next_;
    const std::size_t begin = next_;
    while (next_ < sorted.size() && sorted[next_].vertex == vertex) ++next_;
    return sorted.subspan(begin, next_ - begin);
  }

  /// The first of the corners at that vertex, or at one behind it.
  static std::size_t first_from(std::span<const VertexCorner> sorted, std::uint64_t vertex) {
    const auto at = std::partition_point(sorted.begin(), sorted.end(),
                                         [&](const VertexCorner& c) { return c.vertex < vertex; });
    return static_cast<std::size_t>(at - sorted.begin());
  }

 private:
  std::size_t next_ = 0;
  bool is_placed_ = false;
};

/// The part of a list sorted by vertex that belongs to the points of a block.
std::span<const VertexCorner> part_of(std::span<const VertexCorner> sorted, std::uint32_t block) {
  const std::uint64_t vertex = std::uint64_t{block} * kBlockPoints;
  const std::size_t begin = CornerLookup::first_from(sorted, vertex);
  return sorted.subspan(begin, CornerLookup::first_from(sorted, vertex + kBlockPoints) - begin);
}

/// The part of sorted triangles whose first corners are points of a block.
std::span<const Triangle> part_of(std::span<const Triangle> sorted, std::uint32_t block) {
  const auto first_from = [&](std::uint64_t vertex) {
    return std::partition_point(sorted.begin(), sorted.end(),
                                [&](const Triangle& t) { return t[0] < vertex; });
  };
  const std::uint64_t vertex = std::uint64_t{block} * kBlockPoints;
  return {first_from(vertex), first_from(vertex + kBlockPoints)};
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

template <class T>
void append(std::span<const T> more, std::vector<T>& list) {
  list.insert(list.end(), more.begin(), more.end());
}

constexpr std::uint8_t kMostFans = 255;

/// The number of fans as far as it is counted.
std::uint8_t counted(const FanShape& shape) {
  return static_cast<std::uint8_t>(std::min<std::uint32_t>(shape.fans, kMostFans));
}

void sort_unique(std::vector<VertexCorner>& list) {
  tbb::parallel_sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
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

/// Merges two sorted lists without the members that `taken` lists, which is sorted as well.
template <class Place>
void merge_without(std::span<const Triangle> a, std::span<const Triangle> b,
                   std::span<const Triangle> taken, Place to) {
  std::size_t i = 0, k = 0, t = 0;
  while (i < a.size() || k < b.size()) {
    const bool first = k == b.size() || (i < a.size() && a[i] < b[k]);
    const Triangle& next = first ? a[i++] : b[k++];
    if (t < taken.size() && next == taken[t])
      ++t;
    else
      *to++ = next;
  }
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

/// Triangles that a walk at another of their vertices found, but the walk here did not. Where the
/// walk at a triangle's smallest vertex found the triangle, both others are looked at from there;
/// where it did not, the third vertex is looked at from each of the two that did.
std::vector<VertexCorner> SurfaceState::corners_found_elsewhere(const FanTable& fans) const {
  auto list = gather_over_points<VertexCorner, NoScratch>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<VertexCorner>& out, NoScratch&) {
        const auto is_missing = [&](std::uint32_t at, Corner corner) {
          if (fans.contains(at, corner)) return false;
          out.push_back({at, corner});
          return true;
        };
        for (const Corner c : fans.at(vertex)) {
          const std::uint32_t i = first_of(c), j = second_of(c);
          const Corner at_i = make_corner(j, vertex), at_j = make_corner(vertex, i);
          if (vertex < i && vertex < j) {
            is_missing(i, at_i);
            is_missing(j, at_j);
          } else if (i < j) {
            if (is_missing(i, at_i)) is_missing(j, at_j);
          } else {
            if (is_missing(j, at_j)) is_missing(i, at_i);
          }
        }
      });
  sort_unique(list);
  return list;
}

/// Losers of the conflict rule, smallest vertex first, sorted. Every directed edge is judged at
/// its tail; a closed fan to which nothing was added has no rivals.
std::vector<Triangle> SurfaceState::first_level_losers(
    const FanTable& fans, std::span<const VertexCorner> elsewhere) const {
  struct Scratch {
    CornerLookup lookup;
    std::vector<Corner> all;
    std::vector<Triangle> rivals;
  };
  auto losers = gather_over_points<Triangle, Scratch>(
      fans.points(), stop_,
      [&](std::uint32_t vertex, std::vector<Triangle>& out, Scratch& scratch) {
        const auto added = scratch.lookup.at(elsewhere, vertex);
        if (added.empty() && fans.closed(vertex)) return;
        std::vector<Corner>& all = scratch.all;
        all.assign(fans.at(vertex).begin(), fans.at(vertex).end());
        for (const VertexCorner& c : added) all.push_back(c.corner);
        std::sort(all.begin(), all.end());
        std::vector<Triangle>& rivals = scratch.rivals;
        for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
          end = i + 1;
          while (end < all.size() && first_of(all[end]) == first_of(all[i])) ++end;
          if (end - i < 2) continue;
          rivals.clear();
          for (std::size_t r = i; r < end; ++r) rivals.push_back(triangle_of(vertex, all[r]));
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

/// Settles the vertices that corners were added to: each is closed for good, or open with its
/// corners. The open corners of all others stay as they are. `added`: sorted.
void SurfaceState::close_or_keep(std::span<const VertexCorner> added) {
  struct Settled {
    FanFinder finder;
    std::vector<VertexCorner> corners;  // at the vertex to be settled
    std::vector<VertexCorner> open, pinched;
  };
  const auto settle = [&](std::span<const VertexCorner> corners, Settled& out) {
    const std::uint32_t vertex = corners.front().vertex;
    const FanShape& shape = out.finder.shape_of(corners);
    fan_counts_[vertex] = counted(shape);
    open_[vertex] = shape.closed ? 0 : 1;
    if (shape.closed && shape.fans < 2) return;
    append(corners, shape.closed ? out.pinched : out.open);
  };
  std::vector<Settled> parts(blocks_of(open_.size()));
  tbb::parallel_for(std::uint32_t{0}, blocks_of(open_.size()), [&](std::uint32_t block) {
    check_stop(stop_);
    Settled& out = parts[block];
    std::span<const VertexCorner> kept = part_of(open_corners_, block);
    std::span<const VertexCorner> more = part_of(added, block);
    while (!more.empty()) {
      const std::uint32_t vertex = more.front().vertex;
      std::size_t count = 1, before = 0;
      while (count < more.size() && more[count].vertex == vertex) ++count;
      while (before < kept.size() && kept[before].vertex < vertex) ++before;
      append(kept.first(before), out.open);
      kept = kept.subspan(before);
      std::size_t own = 0;
      while (own < kept.size() && kept[own].vertex == vertex) ++own;
      out.corners.resize(own + count);
      std::merge(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(own), more.begin(),
                 more.begin() + static_cast<std::ptrdiff_t>(count), out.corners.begin());
      settle(out.corners, out);
      kept = kept.subspan(own);
      more = more.subspan(count);
    }
    append(kept, out.open);
  });
  open_corners_ = joined(parts, &Settled::open);
  append<VertexCorner>(joined(parts, &Settled::pinched), pinched_corners_);
}

void SurfaceState::emit_first_level(const FanTable& fans, std::span<const VertexCorner> elsewhere,
                                    std::span<const Triangle> losers) {
  first_level_ = gather_in_blocks<Triangle, CornerLookup>(
      fans.points(), stop_, kBlockTriangles,
      [&](std::uint32_t vertex, std::vector<Triangle>& out, CornerLookup& lookup) {
        if (!is_owned(vertex)) return;
        const std::size_t first = out.size();
        const auto take = [&](Corner c) {
          if (first_of(c) > vertex && second_of(c) > vertex) {
            out.push_back({vertex, first_of(c), second_of(c)});
          }
        };
        for (const Corner c : fans.at(vertex)) take(c);
        for (const VertexCorner& c : lookup.at(elsewhere, vertex)) take(c.corner);
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
  const auto corners = gather_over_points<VertexCorner, CornerLookup>(
      fans.points(), stop_,
      [&](std::uint32_t vertex, std::vector<VertexCorner>& out, CornerLookup& lookup) {
        const std::size_t first = out.size();
        if (touched[vertex] == 0) {
          open_[vertex] = fans.closed(vertex) ? 0 : 1;
          fan_counts_[vertex] = fans.closed(vertex) ? 1 : 0;
          if (fans.closed(vertex)) return;
          for (const Corner c : fans.at(vertex)) out.push_back({vertex, c});
        } else {
          const auto take = [&](Corner c) {
            if (!std::binary_search(losers.begin(), losers.end(), triangle_of(vertex, c)))
              out.push_back({vertex, c});
          };
          for (const Corner c : fans.at(vertex)) take(c);
          for (const VertexCorner& c : lookup.at(elsewhere, vertex)) take(c.corner);
        }
        std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
      });
  close_or_keep(corners);
  for (std::uint32_t vertex = 0; vertex < unfinished_.size(); ++vertex)
    unfinished_[vertex] = fans.blocked(vertex) ? 0 : 1;
  end_level();
}

/// Ends a level: closed points are finished, and open corners can be looked up by their points.
void SurfaceState::end_level() {
  any_unfinished_ = false;
  for (std::size_t i = 0; i < open_.size(); ++i) {
    unfinished_[i] = unfinished_[i] != 0 && open_[i] != 0 ? 1 : 0;
    any_unfinished_ = any_unfinished_ || unfinished_[i] != 0;
  }
  open_begins_.resize(open_.size() + 1);
  tbb::parallel_for(std::uint32_t{0}, blocks_of(open_.size()), [&](std::uint32_t block) {
    const std::size_t vertices =
        std::min<std::size_t>(open_.size(), (std::size_t{block} + 1) * kBlockPoints);
    std::size_t at = CornerLookup::first_from(open_corners_, std::uint64_t{block} * kBlockPoints);
    for (std::size_t vertex = std::size_t{block} * kBlockPoints; vertex < vertices; ++vertex) {
      open_begins_[vertex] = at;
      while (at < open_corners_.size() && open_corners_[at].vertex == vertex) ++at;
    }
  });
  open_begins_.back() = open_corners_.size();
}

/// Whether an open point already has a triangle on the directed edge to `head`.
bool SurfaceState::edge_taken(std::uint32_t tail, std::uint32_t head) const {
  for (std::size_t c = open_begins_[tail]; c < open_begins_[tail + 1]; ++c)
    if (first_of(open_corners_[c].corner) == head) return true;
  return false;
}

void SurfaceState::take_level(const FanTable& fans) {
  auto found = gather_over_points<Triangle, NoScratch>(
      fans.points(), stop_, [&](std::uint32_t vertex, std::vector<Triangle>& out, NoScratch&) {
        for (const Corner c : fans.at(vertex)) {
          const std::uint32_t i = first_of(c), j = second_of(c);
          if (edge_taken(vertex, i) || edge_taken(i, j) || edge_taken(j, vertex)) continue;
          out.push_back(triangle_of(vertex, c));
        }
      });
  tbb::parallel_sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  const std::vector<std::uint8_t> lost = find_losers(context_, found);

  std::vector<VertexCorner> added;
  for (std::size_t t = 0; t < found.size(); ++t) {
    const auto [a, b, c] = found[t];
    if (lost[t] != 0) {
      conflicts_lost_ += is_owned(a) ? 1 : 0;
      continue;
    }
    if (is_owned(a)) later_triangles_.push_back(found[t]);
    added.push_back({a, make_corner(b, c)});
    added.push_back({b, make_corner(c, a)});
    added.push_back({c, make_corner(a, b)});
  }
  for (std::uint32_t vertex = 0; vertex < unfinished_.size(); ++vertex)
    if (fans.blocked(vertex)) unfinished_[vertex] = 0;
  tbb::parallel_sort(added.begin(), added.end());
  close_or_keep(added);
  end_level();
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

/// One list of the triangles of all levels without those that are `isolated`, sorted.
void SurfaceState::merge_levels(std::span<const Triangle> isolated) {
  tbb::parallel_sort(later_triangles_.begin(), later_triangles_.end());
  const auto later = [&](std::size_t block) {
    return part_of(std::span<const Triangle>(later_triangles_), static_cast<std::uint32_t>(block));
  };
  const auto taken = [&](std::size_t block) {
    return part_of(isolated, static_cast<std::uint32_t>(block));
  };
  const std::vector<std::size_t> offsets = offsets_of(first_level_, [&](std::size_t block) {
    return first_level_[block].size() + later(block).size() - taken(block).size();
  });
  reserve_touched(triangles_, offsets.back());
  triangles_.resize(offsets.back());
  tbb::parallel_for(std::size_t{0}, first_level_.size(), [&](std::size_t block) {
    merge_without(first_level_[block], later(block), taken(block),
                  triangles_.begin() + static_cast<std::ptrdiff_t>(offsets[block]));
    first_level_[block] = {};
  });
  later_triangles_ = {};
}

void SurfaceState::drop_isolated() {
  const std::vector<VertexCorner> corners = isolated_corners();
  std::vector<Triangle> isolated;  // sorted, as the corners at their smallest vertices are
  for (const VertexCorner& c : corners) {
    // It was a fan of its own. Where there are more than are counted, they are counted anew.
    if (fan_counts_[c.vertex] < kMostFans) --fan_counts_[c.vertex];
    const Triangle t{c.vertex, first_of(c.corner), second_of(c.corner)};
    if (t == smallest_first(t) && is_owned(c.vertex)) isolated.push_back(t);
  }
  isolated_dropped_ += isolated.size();
  merge_levels(isolated);
  remove_sorted<VertexCorner>(corners, open_corners_);
  open_begins_ = {};  // edges are looked up no more
  count_many_fans_anew(corners);
}

/// Counts the fans that are left at vertices of `dropped` corners that had too many to be counted.
void SurfaceState::count_many_fans_anew(std::span<const VertexCorner> dropped) {
  FanFinder finder;
  CornerLookup left;
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    const std::uint32_t vertex = dropped[i].vertex;
    if (fan_counts_[vertex] < kMostFans || (i > 0 && dropped[i - 1].vertex == vertex)) continue;
    const std::span<const VertexCorner> corners = left.at(open_corners_, vertex);
    fan_counts_[vertex] = corners.empty() ? 0 : counted(finder.shape_of(corners));
  }
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
