// The free directions at a point in a crowd are the part of the unit sphere that lies in the
// point's Voronoi cell. A cell has few sides, however many points there are: those that cut deepest
// are found one after the other, and the caps of nearly all others are clear of what they leave
// free. Included by walk_kernel.inl.

class Walker::Clipping {
 public:
  /// Begins with these neighbours, ascending, at most kMost.
  Clipping(Walker& walker, const std::uint32_t* listed, std::uint32_t count)
      : walker_(walker), count_(count) {
    for (std::uint32_t k = 0; k < count; ++k) side_[k] = {listed[k], false};
  }

  /// Leaves out neighbours that have no part in what is free. True: nothing is.
  bool run() {
    constexpr int kRounds = 24;
    for (int round = 0; round < kRounds; ++round) {
      std::uint32_t listed[kMost];
      for (std::uint32_t k = 0; k < count_; ++k) listed[k] = side_[k].index;
      NearCaps<kFew, kMost> caps(walker_.s_, listed, count_);
      FreeBoundary boundary;
      find_boundary(caps, boundary);
      if (!boundary.known()) return false;
      if (boundary.empty()) return covers_all(caps);
      keep_reaching(caps, boundary, listed);
      if (walker_.n_ < count_ + kFew || !add_deepest(boundary)) return false;
    }
    return false;
  }

 private:
  using Caps = NearCaps<kFew, kMostClipping>;
  static constexpr std::uint32_t kMost = kMostClipping;
  struct Side {
    std::uint32_t index;
    bool buried;  // others cover the whole circle
  };

  void find_boundary(Caps& caps, FreeBoundary& boundary) {
    for (std::uint32_t k = 0; k < count_ && boundary.known(); ++k) {
      if (side_[k].buried) continue;
      const Circle c = walker_.circle_from_top(side_[k].index);
      bool buried = true;
      const auto add = [&](double from, double to) {
        buried = false;
        boundary.add(c, from, to);
      };
      if (!caps.for_each_gap(c, side_[k].index, add)) add(0.0, 4.0);
      side_[k].buried = buried;
    }
  }

  /// Of caps that leave no boundary: whether they leave nothing at all.
  static bool covers_all(const Caps& caps) {
    const Direction probes[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (const Direction& probe : probes)
      if (!caps.hold(probe, kNobody)) return false;
    return true;
  }

  /// Leaves out neighbours whose caps neither reach over the boundary of what is free nor lie
  /// within.
  void keep_reaching(const Caps& caps, const FreeBoundary& boundary, std::uint32_t* sides) {
    const Neighbours& s = walker_.s_;
    std::uint32_t* const listed = walker_.scratch_.list;
    std::uint32_t count_listed = 0;
    for (std::uint32_t k = 0; k < walker_.n_; k += Lanes::kWidth) {
      const auto all = first_lanes(walker_.n_ - k);
      const DirectionOf<Lanes> d = {Lanes::load(s.dx + k), Lanes::load(s.dy + k),
                                    Lanes::load(s.dz + k)};
      auto apart = boundary.clear(d, Lanes::load(s.cap_height + k), all);
      if (any(apart)) apart = caps.hold_surely(scaled(Lanes::load(s.inverse_length + k), d), apart);
      const auto reaching = but_not(all, apart);
      compress_store_indices(listed + count_listed, k, reaching);
      count_listed += count(reaching);
    }
    walker_.keep_only(listed, count_listed, sides, count_);
    for (std::uint32_t k = 0; k < count_; ++k) side_[k].index = sides[k];
  }

  /// Adds the neighbours that cut deepest where the boundary has corners. False: none does.
  bool add_deepest(const FreeBoundary& boundary) {
    const std::uint32_t before = count_;
    for (std::uint32_t p = 0; p < boundary.pieces() && count_ < kMost; ++p) {
      const std::uint32_t deepest = deepest_at(boundary.end(p));
      if (deepest != kNobody) add(deepest);
    }
    return count_ > before;
  }

  /// The neighbour whose cap holds u, as deep as any.
  std::uint32_t deepest_at(Direction u) const {
    const Neighbours& s = walker_.s_;
    const Lanes ux = Lanes::all(u.x), uy = Lanes::all(u.y), uz = Lanes::all(u.z);
    Lanes most = Lanes::all(1e-7), at = Lanes::all(-1.0);
    for (std::uint32_t k = 0; k < walker_.n_; k += Lanes::kWidth) {
      const Lanes inside =
          ux * Lanes::load(s.dx + k) + uy * Lanes::load(s.dy + k) + uz * Lanes::load(s.dz + k);
      const Lanes depth =
          (inside - Lanes::load(s.cap_height + k)) * Lanes::load(s.inverse_length + k);
      const auto deeper = both(first_lanes(walker_.n_ - k), most < depth);
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

  Walker& walker_;
  Side side_[kMost];  // ascending
  std::uint32_t count_;
};
