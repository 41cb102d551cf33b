// The nearest neighbours of a point, side by side. In a crowded place their caps cover nearly the
// whole sphere of a large ball, so that most circles need not be held against anything else.
// Included by walk_kernel.inl.

/// Where a circle enters and leaves the caps of as many neighbours as there are lanes.
struct Crossing {
  Lanes in, out;        // pseudo-angles
  Lanes::Mask crossed;  // the circle leaves the cap again
  Lanes::Mask covered;  // the circle lies in the cap where it is not crossed
};

/// Circle u(t) = m + cos(t) a + sin(t) b against caps about d with half squares h.
struct CircleLanes {
  DirectionOf<Lanes> m, a, b;
  explicit CircleLanes(const Circle& c)
      : m{Lanes::all(c.middle.x), Lanes::all(c.middle.y), Lanes::all(c.middle.z)},
        a{Lanes::all(c.a.x), Lanes::all(c.a.y), Lanes::all(c.a.z)},
        b{Lanes::all(c.b.x), Lanes::all(c.b.y), Lanes::all(c.b.z)} {}
  Crossing cross(DirectionOf<Lanes> d, Lanes h) const {
    const Lanes zero = Lanes::all(0.0);
    const Lanes e = m.x * d.x + m.y * d.y + m.z * d.z - h;
    const Lanes p = a.x * d.x + a.y * d.y + a.z * d.z;
    const Lanes q = b.x * d.x + b.y * d.y + b.z * d.z;
    const Lanes squared = p * p + q * q;
    const Lanes square = squared - e * e;
    const Lanes root = square_root(larger(square, zero));
    const Lanes inverse = Lanes::all(1.0) / squared;
    return {pseudo_angle((root * q - e * p) * inverse, zero - (root * p + e * q) * inverse),
            pseudo_angle(zero - (root * q + e * p) * inverse, (root * p - e * q) * inverse),
            zero < square, zero < e};
  }
};

/// Circles of as many neighbours as there are lanes, t = 0 where each comes closest to the normal
/// of p; each bit for bit that of NeighbourList::circle_from_top.
class TopCircles {
 public:
  TopCircles(DirectionOf<Lanes> d, Lanes height, Lanes inverse_length, Direction normal) {
    const DirectionOf<Lanes> axis = scaled(inverse_length, d);
    const DirectionOf<Lanes> up = {Lanes::all(normal.x), Lanes::all(normal.y),
                                   Lanes::all(normal.z)};
    DirectionOf<Lanes> top = up - scaled(inner(up, axis), axis);
    Lanes squared = inner(top, top);
    const auto known = Lanes::all(1e-24 * inner(normal, normal)) < squared;
    if (count(known) < Lanes::kWidth) {
      const Lanes zero = Lanes::all(0.0), one = Lanes::all(1.0);
      const auto along_y = larger(axis.x, zero - axis.x) < Lanes::all(0.6);
      const DirectionOf<Lanes> other = {choose(along_y, one, zero), choose(along_y, zero, one),
                                        zero};
      const DirectionOf<Lanes> start = other - scaled(inner(other, axis), axis);
      top = {choose(known, top.x, start.x), choose(known, top.y, start.y),
             choose(known, top.z, start.z)};
      squared = choose(known, squared, inner(start, start));
    }
    const Lanes rest = at_least_zero(Lanes::all(1.0) - Lanes::all(0.5) * height);
    const DirectionOf<Lanes> a = scaled(square_root(rest / squared), top);
    put(0, scaled(Lanes::all(0.5), d));
    put(1, a);
    put(2, outer(a, axis));
  }
  Circle at(std::uint32_t lane) const {
    return {{x_[0][lane], y_[0][lane], z_[0][lane]},
            {x_[1][lane], y_[1][lane], z_[1][lane]},
            {x_[2][lane], y_[2][lane], z_[2][lane]}};
  }

 private:
  void put(int which, DirectionOf<Lanes> v) {
    v.x.store(x_[which]);
    v.y.store(y_[which]);
    v.z.store(z_[which]);
  }
  double x_[3][Lanes::kWidth], y_[3][Lanes::kWidth], z_[3][Lanes::kWidth];
};

/// The first of the largest of n values; lanes behind the last are less than all of them.
inline std::uint32_t first_largest(const double* values, std::uint32_t n) {
  Lanes most = Lanes::load(values);
  for (std::uint32_t k = Lanes::kWidth; k < n; k += Lanes::kWidth)
    most = larger(most, Lanes::load(values + k));
  const Lanes wanted = Lanes::all(largest(most));
  for (std::uint32_t k = 0; k < n; k += Lanes::kWidth) {
    const auto equal = Lanes::load(values + k) == wanted;
    if (any(equal))
      return static_cast<std::uint32_t>(
          smallest_of(Lanes::counting_from(static_cast<double>(k)), equal));
  }
  return 0;
}

/// How far ahead of `at` arcs begin; kBeyond where they are none.
inline Lanes way_to(double at, Lanes begin, Lanes length) {
  const Lanes zero = Lanes::all(0.0);
  Lanes ahead = begin - Lanes::all(at);
  ahead = choose(ahead < zero, ahead + Lanes::all(4.0), ahead);
  return choose(Lanes::all(kSliver) < length, ahead, Lanes::all(kBeyond));
}

/// What rounding may make of the depth of a direction in a cap, times the neighbour's distance: the
/// ends of arcs are known to some 1e-8.
inline Lanes rounding_of(Lanes height) {
  return Lanes::all(1e-7) * square_root(height + height) + Lanes::all(1e-12);
}

/// Length of an arc from `in` to `out`, less than a whole circle.
inline Lanes arc_length(Lanes in, Lanes out) {
  const Lanes length = out - in;
  return choose(length < Lanes::all(0.0), length + Lanes::all(4.0), length);
}

/// About kAbout of the nearest neighbours, never more than twice as many; others may be added up to
/// kMost. Which ones decides about time alone.
template <std::uint32_t kAbout, std::uint32_t kMost = 2 * kAbout>
class NearCaps {
 public:
  NearCaps(const Neighbours& all, std::uint32_t n) {
    // Half squares of points spread evenly on a plane are spread evenly.
    double reach = 2.0 * kAbout / n;
    constexpr int kTries = 16;
    double low = 0.0, high = 4.0;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const std::uint32_t within = count_within(all, n, reach);
      if (within > 2 * kAbout) {
        high = reach;
      } else if (2 * within < kAbout) {
        low = reach;
      } else {
        break;
      }
      // A spot may be denser than its surroundings by any factor.
      if (high < 4.0)
        reach = attempt < 4 ? 0.5 * (low + high) : low > 0.0 ? std::sqrt(low * high) : high / 16.0;
      else
        reach = 2.0 * reach;
    }
    take_within(all, n, reach);
  }

  NearCaps() = default;
  /// The neighbours listed instead, at most kMost.
  void take(const Neighbours& all, const std::uint32_t* listed, std::uint32_t count) {
    n_ = count;
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t from = listed[k];
      dx_[k] = all.dx[from], dy_[k] = all.dy[from], dz_[k] = all.dz[from];
      cap_height_[k] = all.cap_height[from];
      index_[k] = static_cast<double>(from);
    }
    fill_up();
  }

  /// Whether these caps cover the circle, and by more than rounding: then so do all caps.
  bool cover(const Circle& c, std::uint32_t self) {
    const std::uint32_t arcs = find_arcs(c, self, kMargin);
    return arcs == kWholly || close_up(arcs);
  }

  /// What the ends of arcs are known to.
  static constexpr double kRounding = 1e-8;

  std::uint32_t size() const { return n_; }
  /// The circles of as many of these as there are lanes, from k on.
  TopCircles circles(std::uint32_t k, Direction normal) const {
    const Lanes height = Lanes::load(cap_height_ + k);
    return {{Lanes::load(dx_ + k), Lanes::load(dy_ + k), Lanes::load(dz_ + k)},
            height,
            Lanes::all(1.0) / square_root(height * Lanes::all(2.0)),
            normal};
  }
  /// Where one of these stands in the list of all neighbours.
  std::uint32_t index(std::uint32_t k) const { return static_cast<std::uint32_t>(index_[k]); }

  /// Calls visit(from, to) for every arc of the circle that these caps leave free, as
  /// pseudo-angles; false where they touch it nowhere. Caps cover less by `margin` at either end:
  /// with kRounding a point where arcs just meet, which rounding may take for free, is one, too.
  template <class Visit>
  bool for_each_gap(const Circle& c, std::uint32_t self, double margin, const Visit& visit) {
    const std::uint32_t arcs = find_arcs(c, self, margin);
    if (arcs == kWholly) return true;
    if (arcs == 0) return false;
    const std::uint32_t longest = begin_tour(arcs);
    double at = begin_[longest], travelled = 0.0;
    for (std::uint32_t round = 0; round < 4 * arcs + 8 && travelled < 4.0 - 1e-12; ++round) {
      double step = reach_beyond(at, arcs);
      if (!(step > kSliver)) {
        step = gap_after(at, arcs);
        visit(at, at + step);
      }
      travelled += step;
      at += step;
      if (at >= 4.0) at -= 4.0;
    }
    return true;
  }

  /// Lanes whose direction one of these caps holds, and not just so.
  Lanes::Mask hold_surely(DirectionOf<Lanes> u, Lanes::Mask wanted) const {
    auto free = wanted;
    for (std::uint32_t k = 0; k < n_ && any(free); ++k) {
      const Lanes height = Lanes::all(cap_height_[k]);
      const Lanes depth =
          u.x * Lanes::all(dx_[k]) + u.y * Lanes::all(dy_[k]) + u.z * Lanes::all(dz_[k]) - height;
      free = but_not(free, rounding_of(height) < depth);
    }
    return but_not(wanted, free);
  }

  /// Whether one of these caps holds u. `but` does not count.
  bool hold(Direction u, std::uint32_t but) const {
    const Lanes ux = Lanes::all(u.x), uy = Lanes::all(u.y), uz = Lanes::all(u.z);
    const Lanes touching = Lanes::all(static_cast<double>(but));
    for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
      const Lanes inside =
          ux * Lanes::load(dx_ + k) + uy * Lanes::load(dy_ + k) + uz * Lanes::load(dz_ + k);
      const auto other = but_not(first_lanes(n_ - k), Lanes::load(index_ + k) == touching);
      if (any(both(other, Lanes::load(cap_height_ + k) < inside))) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kRoom = kMost + 2 * Lanes::kWidth;
  static constexpr std::uint32_t kWholly = 0xffffffffu;
  /// Of a whole circle of 4: arcs are taken to be shorter at both ends.
  static constexpr double kMargin = 1e-9;

  static std::uint32_t count_within(const Neighbours& all, std::uint32_t n, double reach) {
    std::uint32_t within = 0;
    for (std::uint32_t k = 0; k < n; k += Lanes::kWidth)
      within +=
          count(both(first_lanes(n - k), Lanes::load(all.cap_height + k) < Lanes::all(reach)));
    return within;
  }

  void take_within(const Neighbours& all, std::uint32_t n, double reach) {
    for (std::uint32_t k = 0; k < n && n_ < 2 * kAbout; k += Lanes::kWidth) {
      const Lanes height = Lanes::load(all.cap_height + k);
      const auto near = both(first_lanes(n - k), height < Lanes::all(reach));
      if (!any(near)) continue;
      compress_store(dx_ + n_, Lanes::load(all.dx + k), near);
      compress_store(dy_ + n_, Lanes::load(all.dy + k), near);
      compress_store(dz_ + n_, Lanes::load(all.dz + k), near);
      compress_store(cap_height_ + n_, height, near);
      compress_store(index_ + n_, Lanes::counting_from(static_cast<double>(k)), near);
      n_ += count(near);
    }
    if (n_ > 2 * kAbout) n_ = 2 * kAbout;  // whatever the vector width
    fill_up();
  }

  /// Lanes behind the last one hold a cap that no ball ever reaches.
  void fill_up() {
    for (std::uint32_t k = n_; k < n_ + Lanes::kWidth; ++k) {
      dx_[k] = dy_[k] = dz_[k] = 0.0;
      cap_height_[k] = 1.0;
      index_[k] = -1.0;
    }
  }

  /// Arcs of the circle in these caps, shorter by `margin` at both ends; kWholly: one covers it.
  std::uint32_t find_arcs(const Circle& c, std::uint32_t self, double margin) {
    const CircleLanes circle(c);
    const Lanes own = Lanes::all(static_cast<double>(self));
    const Lanes cut = Lanes::all(margin), turn = Lanes::all(4.0);
    std::uint32_t arcs = 0;
    for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
      const DirectionOf<Lanes> d = {Lanes::load(dx_ + k), Lanes::load(dy_ + k),
                                    Lanes::load(dz_ + k)};
      const Crossing at = circle.cross(d, Lanes::load(cap_height_ + k));
      const auto other = but_not(first_lanes(n_ - k), Lanes::load(index_ + k) == own);
      if (any(but_not(both(other, at.covered), at.crossed))) return kWholly;
      const Lanes length = arc_length(at.in, at.out) - cut - cut;
      const auto useful = both(both(other, at.crossed), Lanes::all(0.0) < length);
      Lanes begin = at.in + cut;
      begin = choose(begin < turn, begin, begin - turn);
      compress_store(begin_ + arcs, begin, useful);
      compress_store(length_ + arcs, length, useful);
      arcs += count(useful);
    }
    return arcs;
  }

  /// The longest arc, and lanes behind the last one that cover nothing.
  std::uint32_t begin_tour(std::uint32_t arcs) {
    for (std::uint32_t k = arcs; k < arcs + Lanes::kWidth; ++k) begin_[k] = 0.0, length_[k] = -1.0;
    return first_largest(length_, arcs);
  }

  /// How far beyond `at` the arcs that cover it reach; at most 0 when none does.
  double reach_beyond(double at, std::uint32_t arcs) const {
    const Lanes zero = Lanes::all(0.0), turn = Lanes::all(4.0);
    Lanes reach = Lanes::all(-1.0);
    for (std::uint32_t k = 0; k < arcs; k += Lanes::kWidth) {
      Lanes offset = Lanes::all(at) - Lanes::load(begin_ + k);
      offset = choose(offset < zero, offset + turn, offset);
      reach = larger(reach, Lanes::load(length_ + k) - offset);
    }
    return largest(reach);
  }

  /// From `at` to where the next arc begins.
  double gap_after(double at, std::uint32_t arcs) const {
    Lanes next = Lanes::all(4.0);
    for (std::uint32_t k = 0; k < arcs; k += Lanes::kWidth)
      next = smaller(way_to(at, Lanes::load(begin_ + k), Lanes::load(length_ + k)), next);
    return smallest(next);
  }

  /// Whether the arcs, each of which reaches into the next, go all the way round.
  bool close_up(std::uint32_t arcs) {
    if (arcs == 0) return false;
    double at = begin_[begin_tour(arcs)], travelled = 0.0;
    for (std::uint32_t round = 0; round <= arcs; ++round) {
      const double step = reach_beyond(at, arcs);
      if (!(step > kMargin)) return false;
      travelled += step;
      if (travelled >= 4.0) return true;
      at += step;
      if (at >= 4.0) at -= 4.0;
    }
    return false;
  }

  std::uint32_t n_ = 0;
  double dx_[kRoom], dy_[kRoom], dz_[kRoom], cap_height_[kRoom];
  double index_[kRoom];                  // in the list of all neighbours
  double begin_[kRoom], length_[kRoom];  // arcs of the circle that is looked at
};
