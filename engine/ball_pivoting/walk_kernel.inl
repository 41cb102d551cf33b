// The walk at one point, for the vector width that the including unit selects.
//
// Bernardini, Mittleman, Rushmeier, Silva, Taubin: The Ball-Pivoting Algorithm for Surface
// Reconstruction, 1999, section 4, turned inside out: a ball of radius rho that touches p has its
// centre at p + rho u with |u| = 1; it contains the neighbour at p + rho d exactly when
// u.d > |d|^2 / 2, a cap of the unit sphere. What the caps leave free are the empty balls; corners
// of the free region are triangles at p, arcs between corners are pivots about an edge at p.
//
// The circle of neighbour i is u(t) = d_i / 2 + cos(t) a + sin(t) b. The free region lies to the
// left when t grows, so the corner where the circle enters the cap of j is the triangle (p, i, j)
// with its ball on the positive side. Neighbour k covers u(t) while
//   E + A cos t + B sin t > 0,  E = d_i.d_k / 2 - |d_k|^2 / 2,  A = a.d_k,  B = b.d_k.
// No unit of this file may use anything that is shared with units compiled for other machines.

#include <new>

#include "engine/ball_pivoting/walk.h"
#include "engine/geometry/simd.h"

namespace orbweave {
namespace {

#include "engine/ball_pivoting/walk_geometry.inl"

constexpr std::uint32_t kNobody = 0xffffffffu;
/// Pseudo-angles run over [0, 4); nothing lies there.
constexpr double kBeyond = 8.0;
/// Larger than -cot(t/2) of any crossing that is one.
constexpr double kNever = 1e300;
/// Arcs and gaps below this fraction of a circle are rounding, not geometry.
constexpr double kSliver = 1e-14;
/// About how many of the nearest neighbours a circle is held against before all others, from how
/// many neighbours on, and how many more where there are hundreds.
constexpr std::uint32_t kFew = 16, kMany = 48, kMore = 64;
/// Neighbours are left out before scans only where at least so many circles are to be scanned, or
/// where there are at least so many neighbours; before pairs are tried, where there are at least
/// kManyListed partners. Of kSomeListed those that free cells rule out are left out.
constexpr std::uint32_t kManyWanted = 32, kMostWhole = 200, kSomeListed = 16, kManyListed = 48;
/// With how many of the nearest a search in groups begins.
constexpr std::uint32_t kFewOfCrowd = 24;
/// From how many neighbours on what is free is clipped before anything else is looked at, and the
/// most that clip it.
constexpr std::uint32_t kCrowd = 64, kMostClipping = 96;

/// Monotonic in the angle of (cosine, sine), 0 at angle 0, in [0, 4).
inline Lanes pseudo_angle(Lanes cosine, Lanes sine) {
  return choose(sine < Lanes::all(0.0), Lanes::all(3.0) + cosine, Lanes::all(1.0) - cosine);
}

#include "engine/ball_pivoting/walk_free_region.inl"
#include "engine/ball_pivoting/walk_near_caps.inl"

#include "engine/ball_pivoting/walk_free_boundary.inl"

#include "engine/ball_pivoting/walk_clipping.inl"
#include "engine/ball_pivoting/walk_crowd.inl"
#include "engine/ball_pivoting/walk_suspects.inl"

#include "engine/ball_pivoting/walk_free_cells.inl"

/// Collects the neighbours closer than two ball radii, in the order of the arrays.
void gather(const PointArrays& points, const CandidateRanges& candidates, double ball_radius,
            WalkScratch& scratch) {
  const Lanes px = Lanes::all(points.x[scratch.point]);
  const Lanes py = Lanes::all(points.y[scratch.point]);
  const Lanes pz = Lanes::all(points.z[scratch.point]);
  const Lanes inverse = Lanes::all(1.0 / ball_radius);
  const Lanes four = Lanes::all(4.0);
  const Lanes zero = Lanes::all(0.0);
  const Neighbours to = scratch.neighbours;
  std::uint32_t n = 0;
  for (int r = 0; r < candidates.count; ++r) {
    const std::uint32_t end = candidates.end[r];
    for (std::uint32_t k = candidates.begin[r]; k < end; k += Lanes::kWidth) {
      const Lanes dx = (Lanes::load(points.x + k) - px) * inverse;
      const Lanes dy = (Lanes::load(points.y + k) - py) * inverse;
      const Lanes dz = (Lanes::load(points.z + k) - pz) * inverse;
      const Lanes squared = dx * dx + dy * dy + dz * dz;
      const auto near = both(both(squared < four, zero < squared), first_lanes(end - k));
      if (!any(near)) continue;
      compress_store(to.dx + n, dx, near);
      compress_store(to.dy + n, dy, near);
      compress_store(to.dz + n, dz, near);
      compress_store(to.cap_height + n, squared * Lanes::all(0.5), near);
      compress_store_indices(to.id + n, k, near);
      n += count(near);
    }
  }
  // Lanes behind the last neighbour hold one that no ball ever reaches.
  for (std::uint32_t k = n; k < n + Lanes::kWidth; ++k) {
    to.dx[k] = to.dy[k] = to.dz[k] = 0.0;
    to.cap_height[k] = 1.0;
  }
  scratch.count = n;
}

/// Reciprocal lengths of all neighbours, for walks among all of them.
void invert_lengths(const WalkScratch& scratch, std::uint32_t n) {
  const Neighbours& list = scratch.neighbours;
  for (std::uint32_t k = 0; k < n; k += Lanes::kWidth) {
    const Lanes length = square_root(Lanes::load(list.cap_height + k) * Lanes::all(2.0));
    (Lanes::all(1.0) / length).store(list.inverse_length + k);
  }
}

class Walker {
 public:
  /// `walks`: and not just scans, for which neighbours are left out where that is worth it.
  Walker(const PointArrays& points, const WalkScratch& scratch, bool walks, Fan& fan)
      : points_(points),
        scratch_(scratch),
        s_(scratch.neighbours),
        n_(scratch.count),
        fan_(fan),
        normal_(normal_of(scratch.point)) {
    // A walk among all of a crowd costs more than finding those that matter.
    if (walks && n_ >= kCrowd) leave_out_irrelevant();
  }

  void begin_walk();
  bool walking() const { return state_ == State::kWalking; }
  void step();
  void close_or_scan();
  void suspect(const std::uint8_t* active, const Corner* taken, std::uint32_t taken_count);
  void scan_some(const Corner* suspected, std::uint32_t count, const std::uint8_t* active);

 private:
  enum class State { kFailed, kWalking, kClosed };
  Direction normal_of(std::uint32_t id) const {
    const Vec3& n = points_.normals[id];
    return {n.x, n.y, n.z};
  }
  Direction neighbour(std::uint32_t k) const { return {s_.dx[k], s_.dy[k], s_.dz[k]}; }

  bool is_free(Direction u, std::uint32_t but) const;
  Direction top_of(std::uint32_t i) const;
  bool start(std::uint32_t& circle, Direction& u) const;
  Circle circle_through(std::uint32_t i, Direction u) const {
    return circle_at(neighbour(i), s_.inverse_length[i], u);
  }
  Circle circle_from_top(std::uint32_t i) const;
  std::uint32_t first_entered(const Circle& c, std::uint32_t self) const;
  bool accepted(std::uint32_t i, std::uint32_t j) const;
  bool closed_simply() const;
  void scan_all(const std::uint8_t* active);
  bool wants_two(const std::uint8_t* active) const;
  std::uint32_t list_uncovered(const NearestCaps& near, const std::uint8_t* active) const;
  std::uint32_t keep_listed(const FreeCells& cells, std::uint32_t listed) const;
  bool is_held(Direction u) const;
  bool keep_relevant();
  void leave_out_irrelevant() {
    if (!clipped_) nothing_free_ = keep_relevant();
    clipped_ = true;
  }
  bool cover_arcs(const Circle& c, std::uint32_t self);
  void scan_circle(const Circle& c, std::uint32_t i, const std::uint8_t* active);
  /// Whether triangles with neighbour k are looked for: where points are active, at the first of
  /// their vertices.
  bool is_wanted(std::uint32_t k, const std::uint8_t* active) const {
    return active == nullptr || (s_.id[k] > scratch_.point && active[s_.id[k]] != 0);
  }
  /// Calls visit(circle, k) for the neighbours with which triangles are looked for. t = 0 is
  /// nowhere in particular: pseudo-angles are coarse there, and on a grid the ball of a right
  /// triangle touches its hypotenuse from straight above.
  template <class Visit>
  void for_each_wanted(const std::uint8_t* active, const Visit& visit) const {
    for (std::uint32_t first = 0; first < n_; first += Lanes::kWidth) {
      const std::uint32_t end = n_ - first < Lanes::kWidth ? n_ : first + Lanes::kWidth;
      std::uint32_t k = first;
      while (k < end && !is_wanted(k, active)) ++k;
      if (k == end) continue;
      const DirectionOf<Lanes> d = {Lanes::load(s_.dx + first), Lanes::load(s_.dy + first),
                                    Lanes::load(s_.dz + first)};
      const TopCircles circles(d, Lanes::load(s_.cap_height + first),
                               Lanes::load(s_.inverse_length + first), normal_);
      for (; k < end; ++k)
        if (is_wanted(k, active)) visit(turned(circles.at(k - first)), k);
    }
  }
  std::uint32_t count_wanted(const std::uint8_t* active) const {
    std::uint32_t wanted = 0;
    for (std::uint32_t k = 0; k < n_; ++k) wanted += is_wanted(k, active) ? 1 : 0;
    return wanted;
  }
  std::uint32_t index_of(std::uint32_t id) const;
  double furthest_cover(double from) const;
  std::uint32_t longest_arc() const;
  std::uint32_t next_arc(double from, double& distance) const;
  void emit(std::uint32_t i, std::uint32_t j) {
    fan_.corners[fan_.count++] = make_corner(s_.id[i], s_.id[j]);
  }

  const PointArrays& points_;
  const WalkScratch& scratch_;
  const Neighbours& s_;
  std::uint32_t n_;
  Fan& fan_;
  const Direction normal_;
  bool clipped_ = false;  // irrelevant neighbours have been left out
  bool nothing_free_ = false;
  State state_ = State::kFailed;
  std::uint32_t i_ = kNobody,
                j_ = kNobody;  // the corner that the walk stands at
  std::uint32_t first_i_ = kNobody, first_j_ = kNobody;
};

/// Whether the ball at u is empty; `but` touches the ball and does not count.
bool Walker::is_free(Direction u, std::uint32_t but) const {
  const Lanes ux = Lanes::all(u.x), uy = Lanes::all(u.y), uz = Lanes::all(u.z);
  const Lanes touching = Lanes::all(static_cast<double>(but));
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    const Lanes inside =
        ux * Lanes::load(s_.dx + k) + uy * Lanes::load(s_.dy + k) + uz * Lanes::load(s_.dz + k);
    const Lanes index = Lanes::counting_from(static_cast<double>(k));
    if (any(but_not(Lanes::load(s_.cap_height + k) < inside, index == touching))) return false;
  }
  return true;
}

/// The first neighbour that the circle enters when t grows from 0; kNobody if none.
///
/// With s = sqrt(A^2 + B^2 - E^2), the rising root has -cot(t/2) = (s + B) / (A + E) =
/// (A - E) / (s - B), which grows with t from minus to plus infinity: it is compared instead of t,
/// in the form that does not cancel.
std::uint32_t Walker::first_entered(const Circle& c, std::uint32_t self) const {
  const Lanes mx = Lanes::all(c.middle.x), my = Lanes::all(c.middle.y), mz = Lanes::all(c.middle.z);
  const Lanes ax = Lanes::all(c.a.x), ay = Lanes::all(c.a.y), az = Lanes::all(c.a.z);
  const Lanes bx = Lanes::all(c.b.x), by = Lanes::all(c.b.y), bz = Lanes::all(c.b.z);
  const Lanes own = Lanes::all(static_cast<double>(self));
  const Lanes zero = Lanes::all(0.0);
  Lanes best = Lanes::all(kNever);
  Lanes best_index = Lanes::all(-1.0);
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    const Lanes dx = Lanes::load(s_.dx + k), dy = Lanes::load(s_.dy + k),
                dz = Lanes::load(s_.dz + k);
    const Lanes e = mx * dx + my * dy + mz * dz - Lanes::load(s_.cap_height + k);
    const Lanes a = ax * dx + ay * dy + az * dz;
    const Lanes b = bx * dx + by * dy + bz * dz;
    const Lanes square = a * a + b * b - e * e;
    const Lanes steep = square_root(larger(square, zero)) + larger(b, zero - b);
    const auto falling = b < zero;
    const Lanes angle = choose(falling, a - e, steep) / choose(falling, steep, a + e);
    const Lanes index = Lanes::counting_from(static_cast<double>(k));
    const auto nearer = but_not(both(zero < square, angle < best), index == own);
    best = choose(nearer, angle, best);
    best_index = choose(nearer, index, best_index);
  }
  // Equal angles: the neighbour that comes first wins, whatever the vector width.
  const double nearest = smallest(best);
  if (!(nearest < kNever)) return kNobody;
  return static_cast<std::uint32_t>(smallest_of(best_index, best == Lanes::all(nearest)));
}

Circle Walker::circle_from_top(std::uint32_t i) const {
  return NeighbourList{s_, n_, normal_, scratch_.list}.circle_from_top(i);
}

/// An empty ball that touches a neighbour, as near to the normal as is quick to find.
bool Walker::start(std::uint32_t& circle, Direction& u) const {
  std::uint32_t nearest = 0;
  for (std::uint32_t k = 1; k < n_; ++k) {
    if (s_.cap_height[k] < s_.cap_height[nearest]) nearest = k;
  }
  // On a smooth surface the ball that leans on the nearest neighbour from above is empty.
  u = top_of(nearest);
  if (is_free(u, nearest)) {
    circle = nearest;
    return true;
  }
  const NearCaps<kFew> near(s_, n_);
  for (std::uint32_t k = 0; k < n_; ++k) {
    u = top_of(k);
    if (near.hold(u, k) || !is_free(u, k)) continue;
    circle = k;
    return true;
  }
  return false;
}

/// The ball that touches neighbour i closest to the normal.
Direction Walker::top_of(std::uint32_t i) const {
  const Circle c = circle_from_top(i);
  return {c.middle.x + c.a.x, c.middle.y + c.a.y, c.middle.z + c.a.z};
}

/// The three vertex normals must agree with the triangle's side.
bool Walker::accepted(std::uint32_t i, std::uint32_t j) const {
  const Direction normal = outer(neighbour(i), neighbour(j));
  return inner(normal, normal_) > 0.0 && inner(normal, normal_of(s_.id[i])) > 0.0 &&
         inner(normal, normal_of(s_.id[j])) > 0.0;
}

/// Begins the walk along the boundary of the free region around the normal.
void Walker::begin_walk() {
  state_ = State::kFailed;
  Direction u{};
  if (n_ < 3 || nothing_free_ || !start(i_, u)) return;
  j_ = first_entered(circle_through(i_, u), i_);
  if (j_ == kNobody) return;
  first_i_ = i_;
  first_j_ = j_;
  state_ = State::kWalking;
}

/// One pivot: takes the triangle (p, i, j) and goes on to the next corner.
void Walker::step() {
  const Direction u = ball_at(neighbour(i_), s_.cap_height[i_], neighbour(j_), s_.cap_height[j_]);
  const std::uint32_t next = first_entered(circle_through(j_, u), j_);
  if (!accepted(i_, j_) || fan_.count >= n_ || next == kNobody) {
    state_ = State::kFailed;
    return;
  }
  emit(i_, j_);
  i_ = j_;
  j_ = next;
  if (i_ == first_i_ && j_ == first_j_) state_ = State::kClosed;
}

/// Whether the walk came round as one cycle that meets no neighbour twice.
bool Walker::closed_simply() const {
  if (state_ != State::kClosed || fan_.count < 3) return false;
  for (std::uint32_t x = 0; x < fan_.count; ++x) {
    for (std::uint32_t y = 0; y < x; ++y) {
      if (first_of(fan_.corners[x]) == first_of(fan_.corners[y])) return false;
    }
  }
  return true;
}

/// Arcs of the circle that the neighbours cover. False when one covers it whole.
bool Walker::cover_arcs(const Circle& c, std::uint32_t self) {
  const CircleLanes circle(c);
  const Lanes own = Lanes::all(static_cast<double>(self));
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    const DirectionOf<Lanes> d = {Lanes::load(s_.dx + k), Lanes::load(s_.dy + k),
                                  Lanes::load(s_.dz + k)};
    const Crossing at = circle.cross(d, Lanes::load(s_.cap_height + k));
    const auto other =
        but_not(first_lanes(n_ - k), Lanes::counting_from(static_cast<double>(k)) == own);
    const auto crossed = both(other, at.crossed);
    if (any(but_not(both(other, at.covered), crossed))) return false;
    choose(crossed, at.in, Lanes::all(0.0)).store(scratch_.arc_begin + k);
    choose(crossed, arc_length(at.in, at.out), Lanes::all(-1.0)).store(scratch_.arc_length + k);
  }
  return true;
}

/// How far beyond `from` the arcs that cover it reach; at most 0 when none does.
double Walker::furthest_cover(double from) const {
  const Lanes at = Lanes::all(from), zero = Lanes::all(0.0), turn = Lanes::all(4.0);
  Lanes reach = Lanes::all(-1.0);
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    Lanes offset = at - Lanes::load(scratch_.arc_begin + k);
    offset = choose(offset < zero, offset + turn, offset);
    reach = larger(reach, Lanes::load(scratch_.arc_length + k) - offset);
  }
  return largest(reach);
}

/// The arc that begins next after `from`.
std::uint32_t Walker::next_arc(double from, double& distance) const {
  const auto way_from = [&](std::uint32_t k) {
    return way_to(from, Lanes::load(scratch_.arc_begin + k), Lanes::load(scratch_.arc_length + k));
  };
  Lanes least = Lanes::all(kBeyond);
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) least = smaller(way_from(k), least);
  distance = smallest(least);
  if (!(distance < kBeyond)) return kNobody;
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    const auto nearest = way_from(k) == Lanes::all(distance);
    if (any(nearest))
      return static_cast<std::uint32_t>(
          smallest_of(Lanes::counting_from(static_cast<double>(k)), nearest));
  }
  return kNobody;
}

std::uint32_t Walker::longest_arc() const {
  const std::uint32_t longest = first_largest(scratch_.arc_length, n_);
  return scratch_.arc_length[longest] > kSliver ? longest : kNobody;
}

/// All corners on the circle of neighbour i: ends of its free arcs.
void Walker::scan_circle(const Circle& c, std::uint32_t i, const std::uint8_t* active) {
  if (!cover_arcs(c, i)) return;
  // From the longest arc on, most circles turn out covered within a step or two.
  const std::uint32_t longest = longest_arc();
  if (longest == kNobody) {
    fan_.blocked = false;
    return;
  }
  double at = scratch_.arc_begin[longest];
  double travelled = 0.0;
  // Every round passes one arc or one gap; each of the n arcs begins once.
  for (std::uint32_t round = 0; round < 4 * n_ + 8; ++round) {
    const double reach = furthest_cover(at);
    const bool covered = reach > kSliver;
    std::uint32_t entered = kNobody;
    double step = reach;
    if (!covered) entered = next_arc(at, step);
    travelled += step;
    if (covered) {
      at += step;
      if (at >= 4.0) at -= 4.0;
    } else {
      fan_.blocked = false;
      at = scratch_.arc_begin[entered];
      if (is_wanted(entered, active) && accepted(i, entered)) emit(i, entered);
    }
    if (travelled >= 4.0 - 1e-12) return;
  }
}

/// Leaves out neighbours that have no part in what is free. True: nothing is.
bool Walker::keep_relevant() {
  NeighbourList list{s_, n_, normal_, scratch_.list};
  NearCaps<kFew> near(s_, n_);
  FreeRegion region;
  for (std::uint32_t first = 0; first < near.size(); first += Lanes::kWidth) {
    const TopCircles circles = near.circles(first, normal_);
    for (std::uint32_t k = first; k < near.size() && k < first + Lanes::kWidth; ++k) {
      const Circle c = circles.at(k - first);
      const auto add = [&](double from, double to) { region.add(c, from, to); };
      if (!near.for_each_gap(c, near.index(k), near.kRounding, add)) region.forget();
    }
  }
  std::uint32_t also[2 * kFew];
  for (std::uint32_t k = 0; k < near.size(); ++k) also[k] = near.index(k);
  if (region.encloses_all([&](Direction u) { return near.hold(u, kNobody); })) {
    region.drop_covered(s_, n_);
    if (region.empty()) return true;
    // The nearest enclose the rest of the region: they stay, too.
    list.keep_only(region.list_relevant(s_, n_, scratch_.list), also, near.size());
  }
  bool nothing_free = false;
  if (list.n >= kCrowd)
    nothing_free =
        Clipping(list, also, near.size(), near.kRounding).run() == Clipping::Outcome::kNothingFree;
  n_ = list.n;
  return nothing_free;
}

void Walker::scan_all(const std::uint8_t* active) {
  fan_.count = 0;
  fan_.blocked = false;
  const std::uint32_t wanted = active == nullptr ? n_ : count_wanted(active);
  if (active != nullptr && wanted < 2) return;
  if (n_ >= kMany && (wanted >= kManyWanted || n_ >= kMostWhole)) leave_out_irrelevant();
  if (nothing_free_) {
    fan_.blocked = true;
    return;
  }
  fan_.blocked = active == nullptr && n_ > 0;
  if (n_ < kMany) {
    for_each_wanted(active, [&](const Circle& c, std::uint32_t i) { scan_circle(c, i, active); });
    return;
  }
  NearCaps<kFew> few(s_, n_);
  // Of a crowd the circles that are left are many enough to be held against some more first.
  NearCaps<kMore> more(s_, n_ < kMore * 4 ? 0 : n_);
  for_each_wanted(active, [&](const Circle& c, std::uint32_t i) {
    if (!few.cover(c, i) && !more.cover(c, i)) scan_circle(c, i, active);
  });
}

/// The fan that the walk closed, or else all triangles.
void Walker::close_or_scan() {
  fan_.closed = closed_simply();
  fan_.blocked = false;
  if (!fan_.closed) scan_all(nullptr);
}

/// Where a neighbour stands; kNobody if it is none. Neighbours are in the order of the arrays.
std::uint32_t Walker::index_of(std::uint32_t id) const {
  std::uint32_t begin = 0, end = n_;
  while (begin < end) {
    const std::uint32_t middle = begin + (end - begin) / 2;
    if (s_.id[middle] == id) return middle;
    if (s_.id[middle] < id) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return kNobody;
}

/// All corners on the circles of the neighbours that come first in `suspected`.
void Walker::scan_some(const Corner* suspected, std::uint32_t count, const std::uint8_t* active) {
  fan_.count = 0;
  fan_.closed = fan_.blocked = false;
  for (std::uint32_t c = 0; c < count; ++c) {
    if (c > 0 && first_of(suspected[c]) == first_of(suspected[c - 1])) continue;
    const std::uint32_t k = index_of(first_of(suspected[c]));
    if (k == kNobody) continue;
    s_.inverse_length[k] = 1.0 / std::sqrt(s_.cap_height[k] * 2.0);
    scan_circle(turned(circle_from_top(k)), k, active);
  }
}

#include "engine/ball_pivoting/walk_first_look.inl"
#include "engine/ball_pivoting/walk_lockstep.inl"

/// Takes one pivot each in turns: every pivot is a long chain of dependent operations, and
/// independent chains fill each other's waiting times.
void walk_in_turns(Walker* walkers, std::uint32_t count) {
  for (std::uint32_t w = 0; w < count; ++w) walkers[w].begin_walk();
  for (bool any_left = true; any_left;) {
    any_left = false;
    for (std::uint32_t w = 0; w < count; ++w) {
      if (!walkers[w].walking()) continue;
      walkers[w].step();
      any_left = true;
    }
  }
}

/// Walks among the nearest neighbours. Fans that are not sure to be those among all stay open.
void walk_among_near(const PointArrays& points, const WalkScratch* scratch, std::uint32_t count,
                     Fan* fans) {
  for (std::uint32_t w = 0; w < count; w += Lanes::kWidth) {
    LockstepWalk lockstep(points, scratch + w, count - w);
    lockstep.run();
    for (std::uint32_t lane = 0; lane < Lanes::kWidth && w + lane < count; ++lane) {
      lockstep.take(lane, fans[w + lane]);
    }
  }
}

std::uint32_t walk(const PointArrays& points, const WalkScratch* scratch, std::uint32_t count,
                   bool nearest_first, Fan* fans) {
  for (std::uint32_t w = 0; w < count; ++w) fans[w].closed = fans[w].blocked = false;
  if (nearest_first) walk_among_near(points, scratch, count, fans);
  alignas(Walker) unsigned char room[kWalksAtOnce * sizeof(Walker)];
  Walker* walkers = reinterpret_cast<Walker*>(room);
  std::uint32_t left = 0;
  for (std::uint32_t w = 0; w < count; ++w) {
    if (fans[w].closed) continue;
    fans[w].count = 0;
    invert_lengths(scratch[w], scratch[w].count);
    new (walkers + left++) Walker(points, scratch[w], true, fans[w]);
  }
  walk_in_turns(walkers, left);
  for (std::uint32_t w = 0; w < left; ++w) walkers[w].close_or_scan();
  return count - left;
}

void suspect(const PointArrays& points, const WalkScratch& scratch, const std::uint8_t* active,
             const Corner* taken, std::uint32_t taken_count, Fan& fan) {
  Walker(points, scratch, false, fan).suspect(active, taken, taken_count);
}

void confirm(const PointArrays& points, const WalkScratch& scratch, const std::uint8_t* active,
             const Corner* suspected, std::uint32_t count, Fan& fan) {
  Walker(points, scratch, false, fan).scan_some(suspected, count, active);
}

}  // namespace
}  // namespace orbweave
