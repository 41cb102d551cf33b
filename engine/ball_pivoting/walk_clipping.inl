// The free directions at a point in a crowd are the part of the unit sphere that lies in the
// point's Voronoi cell. A cell has few sides, however many points there are: those that cut deepest
// are found one after the other, and the caps of nearly all others are clear of what they leave
// free. Included by walk_kernel.inl.

/// Neighbours of a point, of which some may be left out.
struct NeighbourList {
  const Neighbours& s;
  std::uint32_t n;
  Direction normal;       // of the point
  std::uint32_t* listed;  // room for n indices

  Direction neighbour(std::uint32_t k) const { return {s.dx[k], s.dy[k], s.dz[k]}; }
  Circle circle_from_top(std::uint32_t i) const;
  void keep_only(std::uint32_t count, std::uint32_t* also, std::uint32_t also_count);
  void end_list() const;
};

/// The circle of neighbour i, t = 0 where it comes closest to the normal of p.
Circle NeighbourList::circle_from_top(std::uint32_t i) const {
  const Direction d = neighbour(i);
  const Direction axis = scaled(s.inverse_length[i], d);
  Direction top = normal - scaled(inner(normal, axis), axis);
  double squared = inner(top, top);
  if (!(squared > 1e-24 * inner(normal, normal))) {
    // The neighbour stands along the normal: every start is as good as another.
    const Direction any = std::fabs(axis.x) < 0.6 ? Direction{1, 0, 0} : Direction{0, 1, 0};
    top = any - scaled(inner(any, axis), axis);
    squared = inner(top, top);
  }
  const double rest = 1.0 - 0.5 * s.cap_height[i];
  const Direction a = scaled(std::sqrt((rest > 0.0 ? rest : 0.0) / squared), top);
  return {scaled(0.5, d), a, outer(a, axis)};
}

/// Lanes behind the last neighbour hold one that no ball ever reaches.
void NeighbourList::end_list() const {
  for (std::uint32_t k = n; k < n + Lanes::kWidth; ++k) {
    s.dx[k] = s.dy[k] = s.dz[k] = 0.0;
    s.cap_height[k] = 1.0;
  }
}

/// Leaves out all neighbours but the first `count` that are listed, and those of `also`; both
/// ascending. The latter are renumbered.
void NeighbourList::keep_only(std::uint32_t count, std::uint32_t* also, std::uint32_t also_count) {
  std::uint32_t kept = 0, next = 0;
  const auto keep = [&](std::uint32_t k) {
    double* const arrays[] = {s.dx, s.dy, s.dz, s.cap_height, s.inverse_length};
    for (double* const array : arrays) array[kept] = array[k];
    s.id[kept] = s.id[k];
    return kept++;
  };
  for (std::uint32_t l = 0; l < count; ++l) {
    for (; next < also_count && also[next] < listed[l]; ++next) also[next] = keep(also[next]);
    if (next < also_count && also[next] == listed[l]) {
      also[next++] = keep(listed[l]);
    } else {
      keep(listed[l]);
    }
  }
  for (; next < also_count; ++next) also[next] = keep(also[next]);
  n = kept;
  end_list();
}

class Clipping {
 public:
  enum class Outcome { kUnknown, kNothingFree, kClipped };
  using Caps = NearCaps<kFew, kMostClipping>;

  /// Begins with the first `count` neighbours listed, ascending, at most kMost. `margin`: as for
  /// NearCaps::for_each_gap.
  Clipping(NeighbourList& list, const std::uint32_t* listed, std::uint32_t count, double margin)
      : list_(list), count_(count), margin_(margin) {
    for (std::uint32_t k = 0; k < count; ++k) side_[k] = {listed[k], false};
  }

  /// Leaves out neighbours that have no part in what is free. Where that is known afterwards,
  /// caps() and boundary() tell it.
  Outcome run() {
    constexpr int kRounds = 24;
    for (int round = 0; round < kRounds; ++round) {
      std::uint32_t sides[kMost];
      for (std::uint32_t k = 0; k < count_; ++k) sides[k] = side_[k].index;
      caps_.take(list_.s, sides, count_);
      boundary_.clear();
      find_boundary();
      if (!boundary_.known()) return Outcome::kUnknown;
      if (boundary_.empty()) return covers_all() ? Outcome::kNothingFree : Outcome::kUnknown;
      keep_reaching(sides);
      if (list_.n < count_ + kFew || !add_deepest()) break;
    }
    return Outcome::kClipped;
  }
  const Caps& caps() const { return caps_; }
  const FreeBoundary& boundary() const { return boundary_; }

 private:
  static constexpr std::uint32_t kMost = kMostClipping;
  struct Side {
    std::uint32_t index;
    bool buried;  // others cover the whole circle
  };

  void find_boundary() {
    for (std::uint32_t first = 0; first < count_; first += Lanes::kWidth) {
      const std::uint32_t end = count_ - first < Lanes::kWidth ? count_ : first + Lanes::kWidth;
      std::uint32_t k = first;
      while (k < end && side_[k].buried) ++k;
      if (k == end) continue;
      const TopCircles circles = caps_.circles(first, list_.normal);
      for (; k < end && boundary_.known(); ++k) {
        if (side_[k].buried) continue;
        const Circle c = circles.at(k - first);
        bool buried = true;
        const auto add = [&](double from, double to) {
          buried = false;
          boundary_.add(c, from, to);
        };
        if (!caps_.for_each_gap(c, side_[k].index, margin_, add)) add(0.0, 4.0);
        side_[k].buried = buried;
      }
    }
  }

  /// Of caps that leave no boundary: whether they leave nothing at all.
  bool covers_all() const {
    const Direction probes[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (const Direction& probe : probes)
      if (!caps_.hold(probe, kNobody)) return false;
    return true;
  }

  /// Leaves out neighbours whose caps neither reach over the boundary of what is free nor lie
  /// within.
  void keep_reaching(std::uint32_t* sides) {
    const Neighbours& s = list_.s;
    std::uint32_t count_listed = 0;
    for (std::uint32_t k = 0; k < list_.n; k += Lanes::kWidth) {
      const auto all = first_lanes(list_.n - k);
      const DirectionOf<Lanes> d = {Lanes::load(s.dx + k), Lanes::load(s.dy + k),
                                    Lanes::load(s.dz + k)};
      const Lanes height = Lanes::load(s.cap_height + k);
      auto apart = boundary_.stays_below(d, height - rounding_of(height), all);
      if (any(apart))
        apart = caps_.hold_surely(scaled(Lanes::load(s.inverse_length + k), d), apart);
      const auto reaching = but_not(all, apart);
      compress_store_indices(list_.listed + count_listed, k, reaching);
      count_listed += count(reaching);
    }
    list_.keep_only(count_listed, sides, count_);
    for (std::uint32_t k = 0; k < count_; ++k) side_[k].index = sides[k];
  }

  /// Adds the neighbours that cut deepest where the boundary has corners. False: none does.
  bool add_deepest() {
    const std::uint32_t before = count_;
    for (std::uint32_t p = 0; p < boundary_.pieces() && count_ < kMost; ++p) {
      const std::uint32_t deepest = deepest_at(boundary_.end(p));
      if (deepest != kNobody) add(deepest);
    }
    return count_ > before;
  }

  /// The neighbour whose cap holds u, as deep as any.
  std::uint32_t deepest_at(Direction u) const {
    const Neighbours& s = list_.s;
    const Lanes ux = Lanes::all(u.x), uy = Lanes::all(u.y), uz = Lanes::all(u.z);
    Lanes most = Lanes::all(1e-7), at = Lanes::all(-1.0);
    for (std::uint32_t k = 0; k < list_.n; k += Lanes::kWidth) {
      const Lanes inside =
          ux * Lanes::load(s.dx + k) + uy * Lanes::load(s.dy + k) + uz * Lanes::load(s.dz + k);
      const Lanes depth =
          (inside - Lanes::load(s.cap_height + k)) * Lanes::load(s.inverse_length + k);
      const auto deeper = both(first_lanes(list_.n - k), most < depth);
      most = choose(deeper, depth, most);
      at = choose(deeper, Lanes::counting_from(static_cast<double>(k)), at);
    }
    const auto deepest = both(most == Lanes::all(largest(most)), Lanes::all(-0.5) < at);
    return any(deepest) ? static_cast<std::uint32_t>(smallest_of(at, deepest)) : kNobody;
  }

  void add(std::uint32_t index) {
    std::uint32_t at = count_;
    while (at > 0 && side_[at - 1].index > index) --at;
    if (at > 0 && side_[at - 1].index == index) return;
    for (std::uint32_t k = count_; k > at; --k) side_[k] = side_[k - 1];
    side_[at] = {index, false};
    ++count_;
  }

  NeighbourList& list_;
  Side side_[kMost];  // ascending
  std::uint32_t count_;
  const double margin_;
  Caps caps_;
  FreeBoundary boundary_;
};
