// Walks at as many points as there are lanes, among the nearest neighbours alone, and the proof
// that looking at the others as well would have changed nothing. Included by walk_kernel.inl.
//
// Neighbours further away take no part in a pivot from u about neighbour j to the corner at t* when
// none of them comes into the ball on the way: when E + A cos t + B sin t < 0 for t in [0, t*].
// That is u(t).d - |d|^2 / 2, linear in u(t), and the arc lies in the triangle of its ends and of
// the point where its tangents there meet, u(0) + tan(t*/2) b: it is enough to look at these three.
// Where that fails, or the walk among the nearest does not close, Walker walks among all.

/// A ball this far from touching a neighbour, in ball radii, is clear of it beyond doubt: rounding
/// moves an entry by far less (the quadratic's coefficients are off by 1e-14 at most, divided by no
/// less than -(A + E) > kClear).
constexpr double kClear = 1e-4;
/// What the end of an arc and the corner there may differ by.
constexpr double kSameBall = 1e-6;
/// Arcs turn by less than half a circle: their -cot(t*/2) is below that.
constexpr double kLargestTurn = -1e-2;
/// How far the nearest reach, by |d|^2 / 2: about a third of all neighbours, 8 to 18 of them, hold
/// most fans. Any choice gives the same fans.
inline double near_cap_for(double neighbours) {
  const double third = 2.0 / 3.0, least = 16.0 / neighbours, most = 36.0 / neighbours;
  return third < least ? least : (third > most ? most : third);
}

class LockstepWalk {
 public:
  /// `walks`: how many lanes are wanted; more than there are lanes are left out.
  LockstepWalk(const PointArrays& points, const WalkScratch* scratch, std::uint32_t walks);
  void run();
  /// The fan of a lane whose walk closed simply and surely; others are left as they are.
  void take(std::uint32_t lane, Fan& fan) const;

 private:
  using Directions = DirectionOf<Lanes>;
  using Mask = Lanes::Mask;
  static constexpr std::uint32_t kWidth = Lanes::kWidth;
  static constexpr std::uint32_t kMostNear = 24;
  static constexpr std::uint32_t kMostSteps = 14;

  /// A neighbour per lane.
  struct Near {
    Lanes index;
    Directions d, normal;
    Lanes cap_height, inverse_length;
  };
  /// Rows of lanes, one row per neighbour or step.
  template <std::uint32_t kRows>
  struct Rows {
    double x[kRows * kWidth], y[kRows * kWidth], z[kRows * kWidth];
    Directions at(std::uint32_t row) const {
      return {Lanes::load(x + row * kWidth), Lanes::load(y + row * kWidth),
              Lanes::load(z + row * kWidth)};
    }
    /// One lane's, in every lane.
    Directions all_at(std::uint32_t row, std::uint32_t lane) const {
      const std::uint32_t at = row * kWidth + lane;
      return {Lanes::all(x[at]), Lanes::all(y[at]), Lanes::all(z[at])};
    }
    void set(std::uint32_t row, Directions d) {
      d.x.store(x + row * kWidth);
      d.y.store(y + row * kWidth);
      d.z.store(z + row * kWidth);
    }
  };

  void choose_near(std::uint32_t lane);
  void fill_up();
  Near near(std::uint32_t k) const;
  static Near choose_one(Mask m, const Near& yes, const Near& no);
  Near nearest() const;
  Directions top_of(const Near& i, Mask& sure) const;
  Mask is_free(Directions u, Lanes but) const;
  Near first_entered(const CircleOf<Lanes>& c, Lanes self, Lanes& angle) const;
  Directions follow(std::uint32_t arc, Directions u, const CircleOf<Lanes>& c, Lanes angle);
  void close(Mask lanes, std::uint32_t steps);
  bool is_clear(std::uint32_t lane) const;

  const PointArrays& points_;
  const WalkScratch* scratch_;
  std::uint32_t walks_;
  std::uint32_t rows_ = 1;           // most near neighbours of a lane
  std::uint32_t near_[kWidth] = {};  // how many a lane has
  double near_cap_[kWidth] = {};     // the cap height below which they are near
  Rows<kMostNear + 1> d_, normal_;   // of the near neighbours
  double cap_height_[(kMostNear + 1) * kWidth];
  double inverse_length_[(kMostNear + 1) * kWidth];
  std::uint32_t id_[(kMostNear + 1) * kWidth];
  Rows<kMostSteps + 3> ball_;                 // where arcs begin; the first is no corner
  Rows<kMostSteps + 3> tangents_;             // where the tangents of an arc's ends meet
  double around_[(kMostSteps + 1) * kWidth];  // the neighbours of the fan, by step
  std::uint32_t steps_[kWidth] = {};  // triangles of the walks that came round, 0 for others
  Directions own_normal_;
};

LockstepWalk::LockstepWalk(const PointArrays& points, const WalkScratch* scratch,
                           std::uint32_t walks)
    : points_(points), scratch_(scratch), walks_(walks < kWidth ? walks : kWidth) {
  double x[kWidth] = {}, y[kWidth] = {}, z[kWidth] = {};
  for (std::uint32_t lane = 0; lane < walks_; ++lane) {
    choose_near(lane);
    const Vec3& n = points.normals[scratch[lane].point];
    x[lane] = n.x, y[lane] = n.y, z[lane] = n.z;
  }
  own_normal_ = {Lanes::load(x), Lanes::load(y), Lanes::load(z)};
  fill_up();
}

/// Copies a lane's nearest neighbours, in order. None where they are too many.
void LockstepWalk::choose_near(std::uint32_t lane) {
  const Neighbours& from = scratch_[lane].neighbours;
  const std::uint32_t n = scratch_[lane].count;
  near_cap_[lane] = near_cap_for(n);
  std::uint32_t list[kMostNear + 2 * kWidth];
  std::uint32_t chosen = 0;
  for (std::uint32_t k = 0; k < n && chosen <= kMostNear; k += kWidth) {
    const Mask is_near =
        both(first_lanes(n - k), Lanes::load(from.cap_height + k) < Lanes::all(near_cap_[lane]));
    compress_store_indices(list + chosen, k, is_near);
    chosen += count(is_near);
  }
  if (chosen > kMostNear) return;
  for (std::uint32_t row = 0; row < chosen; ++row) {
    const std::uint32_t k = list[row], to = row * kWidth + lane;
    d_.x[to] = from.dx[k], d_.y[to] = from.dy[k], d_.z[to] = from.dz[k];
    cap_height_[to] = from.cap_height[k];
    const Vec3& normal = points_.normals[from.id[k]];
    normal_.x[to] = normal.x, normal_.y[to] = normal.y, normal_.z[to] = normal.z;
    id_[to] = from.id[k];
  }
  near_[lane] = chosen;
  rows_ = rows_ < chosen ? chosen : rows_;
}

/// Rows behind a lane's last neighbour hold one that no ball ever reaches.
void LockstepWalk::fill_up() {
  for (std::uint32_t lane = 0; lane < kWidth; ++lane) {
    for (std::uint32_t k = near_[lane]; k < rows_; ++k) {
      const std::uint32_t to = k * kWidth + lane;
      d_.x[to] = d_.y[to] = d_.z[to] = 0.0;
      normal_.x[to] = normal_.y[to] = normal_.z[to] = 0.0;
      cap_height_[to] = 1.0;
    }
  }
  for (std::uint32_t k = 0; k < rows_; ++k) {
    const Lanes length = square_root(Lanes::load(cap_height_ + k * kWidth) * Lanes::all(2.0));
    (Lanes::all(1.0) / length).store(inverse_length_ + k * kWidth);
  }
}

LockstepWalk::Near LockstepWalk::near(std::uint32_t k) const {
  return {Lanes::all(static_cast<double>(k)), d_.at(k), normal_.at(k),
          Lanes::load(cap_height_ + k * kWidth), Lanes::load(inverse_length_ + k * kWidth)};
}

LockstepWalk::Near LockstepWalk::choose_one(Mask m, const Near& yes, const Near& no) {
  const auto direction = [m](Directions a, Directions b) {
    return Directions{choose(m, a.x, b.x), choose(m, a.y, b.y), choose(m, a.z, b.z)};
  };
  return {choose(m, yes.index, no.index), direction(yes.d, no.d), direction(yes.normal, no.normal),
          choose(m, yes.cap_height, no.cap_height),
          choose(m, yes.inverse_length, no.inverse_length)};
}

LockstepWalk::Near LockstepWalk::nearest() const {
  Near best = near(0);
  for (std::uint32_t k = 1; k < rows_; ++k) {
    const Near other = near(k);
    best = choose_one(other.cap_height < best.cap_height, other, best);
  }
  return best;
}

/// The ball on the circle of neighbour i that comes closest to the normal (Walker's
/// circle_from_top); not sure where the neighbour stands along the normal.
LockstepWalk::Directions LockstepWalk::top_of(const Near& i, Mask& sure) const {
  const Directions axis = scaled(i.inverse_length, i.d);
  const Directions top = own_normal_ - scaled(inner(own_normal_, axis), axis);
  const Lanes squared = inner(top, top);
  sure = both(sure, Lanes::all(1e-24) * inner(own_normal_, own_normal_) < squared);
  const Lanes rest = Lanes::all(1.0) - Lanes::all(0.5) * i.cap_height;
  const Directions a = scaled(square_root(at_least_zero(rest) / squared), top);
  return scaled(Lanes::all(0.5), i.d) + a;
}

LockstepWalk::Mask LockstepWalk::is_free(Directions u, Lanes but) const {
  Mask free = first_lanes(walks_);
  for (std::uint32_t k = 0; k < rows_; ++k) {
    const Lanes inside = inner(u, d_.at(k));
    const Mask hit = but_not(Lanes::load(cap_height_ + k * kWidth) < inside,
                             Lanes::all(static_cast<double>(k)) == but);
    free = but_not(free, hit);
  }
  return free;
}

/// Walker's first_entered, one circle per lane. `angle` is kNever where none is entered.
LockstepWalk::Near LockstepWalk::first_entered(const CircleOf<Lanes>& c, Lanes self,
                                               Lanes& angle) const {
  const Lanes zero = Lanes::all(0.0);
  angle = Lanes::all(kNever);
  Near best = near(0);
  for (std::uint32_t k = 0; k < rows_; ++k) {
    const Near other = near(k);
    const Lanes e = inner(c.middle, other.d) - other.cap_height;
    const Lanes a = inner(c.a, other.d);
    const Lanes b = inner(c.b, other.d);
    const Lanes square = a * a + b * b - e * e;
    const Lanes steep = square_root(larger(square, zero)) + larger(b, zero - b);
    const auto falling = b < zero;
    const Lanes at = choose(falling, a - e, steep) / choose(falling, steep, a + e);
    const auto nearer = but_not(both(zero < square, at < angle), other.index == self);
    angle = choose(nearer, at, angle);
    best = choose_one(nearer, other, best);
  }
  return best;
}

/// Keeps what is_clear() looks at of the arc from u to where -cot(t/2) is `angle`. Returns its end.
LockstepWalk::Directions LockstepWalk::follow(std::uint32_t arc, Directions u,
                                              const CircleOf<Lanes>& c, Lanes angle) {
  ball_.set(arc, u);
  tangents_.set(arc, u + scaled(Lanes::all(-1.0) / angle, c.b));
  // cos t - 1 = -2 / (1 + q^2), sin t = -2 q / (1 + q^2).
  const Lanes chord = Lanes::all(-2.0) / (Lanes::all(1.0) + angle * angle);
  return u + scaled(chord, c.a + scaled(angle, c.b));
}

/// Lanes whose two balls are the same.
inline Lanes::Mask same_ball(DirectionOf<Lanes> a, DirectionOf<Lanes> b) {
  const DirectionOf<Lanes> apart = a - b;
  return inner(apart, apart) < Lanes::all(kSameBall * kSameBall);
}

/// Walks of these lanes came round after this number of triangles.
void LockstepWalk::close(Mask lanes, std::uint32_t steps) {
  if (!any(lanes)) return;
  for (std::uint32_t lane = 0; lane < walks_; ++lane) {
    if (any(both(lanes, lane_mask(lane)))) steps_[lane] = steps;
  }
}

/// The walks, all lanes in step; a lane that leaves the loop without close() stays undecided.
void LockstepWalk::run() {
  Mask going = first_lanes(walks_);
  for (std::uint32_t lane = 0; lane < walks_; ++lane) {
    if (near_[lane] < 3) going = but_not(going, lane_mask(lane));
  }
  const Near first = nearest();
  Near i = first;
  Directions u = top_of(i, going);
  going = both(going, is_free(u, i.index));
  // Under noise few walks begin here, and those that do end soon.
  if (4 * count(going) < 3 * walks_) return;
  Lanes angle;
  CircleOf<Lanes> circle = circle_at(i.d, i.inverse_length, u);
  Near j = first_entered(circle, i.index, angle);
  Directions end = follow(0, u, circle, angle);
  going = both(going, angle < Lanes::all(kLargestTurn));
  const Lanes first_j = j.index;
  Directions first_ball = u;
  for (std::uint32_t step = 0; step < kMostSteps && any(going); ++step) {
    u = ball_at(i.d, i.cap_height, j.d, j.cap_height);
    if (step == 0) first_ball = u;
    going = both(going, same_ball(u, end));
    circle = circle_at(j.d, j.inverse_length, u);
    const Near next = first_entered(circle, j.index, angle);
    end = follow(step + 1, u, circle, angle);
    const Lanes zero = Lanes::all(0.0);
    const Directions normal = outer(i.d, j.d);
    going = both(both(going, angle < Lanes::all(kLargestTurn)),
                 both(zero < inner(normal, own_normal_),
                      both(zero < inner(normal, i.normal), zero < inner(normal, j.normal))));
    i.index.store(around_ + step * kWidth);
    i = j;
    j = next;
    const Mask closed = both(both(going, i.index == first.index), j.index == first_j);
    close(both(closed, same_ball(first_ball, end)), step + 1);
    going = but_not(going, closed);
  }
}

/// Whether no neighbour but the nearest comes close to a ball on the way.
bool LockstepWalk::is_clear(std::uint32_t lane) const {
  const Neighbours& all = scratch_[lane].neighbours;
  const std::uint32_t n = scratch_[lane].count;
  const std::uint32_t arcs = steps_[lane] + 1;  // the last one ends where the second one begins
  for (std::uint32_t k = 0; k < n; k += kWidth) {
    const Lanes cap_height = Lanes::load(all.cap_height + k);
    const auto others = but_not(first_lanes(n - k), cap_height < Lanes::all(near_cap_[lane]));
    const Directions d = {Lanes::load(all.dx + k), Lanes::load(all.dy + k),
                          Lanes::load(all.dz + k)};
    Lanes begins = Lanes::all(-kNever), tangents = Lanes::all(-kNever);
    for (std::uint32_t c = 0; c < arcs; ++c) {
      begins = larger(begins, inner(ball_.all_at(c, lane), d));
      tangents = larger(tangents, inner(tangents_.all_at(c, lane), d));
    }
    const auto clear = larger(begins, tangents) < cap_height - Lanes::all(kClear);
    if (any(but_not(others, clear))) return false;
  }
  return true;
}

void LockstepWalk::take(std::uint32_t lane, Fan& fan) const {
  const std::uint32_t n = steps_[lane];
  if (n < 3 || !is_clear(lane)) return;
  const auto neighbour = [&](std::uint32_t step) {
    return static_cast<std::uint32_t>(around_[step * kWidth + lane]);
  };
  bool met[kMostNear] = {};
  for (std::uint32_t step = 0; step < n; ++step) {
    const std::uint32_t i = neighbour(step), j = neighbour(step + 1 == n ? 0 : step + 1);
    if (met[i]) return;
    met[i] = true;
    fan.corners[step] = make_corner(id_[i * kWidth + lane], id_[j * kWidth + lane]);
  }
  fan.count = n;
  fan.closed = true;
}
