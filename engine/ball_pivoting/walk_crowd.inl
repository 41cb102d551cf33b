// The neighbours at a point in a crowd, without a look at each: what a few of them leave free is
// held against spheres that hold groups of points. Included by walk_kernel.inl.
//
// A ball about u that touches p is clear of a group within radius r of c when |u - c| > 1 + r, or
// u.c < (|c|^2 - 2 r - r^2) / 2: linear in u again. When that holds along the whole boundary of
// what is free, the caps of all places within the group lie within what is free or outside of it,
// and all on the same side: one direction tells.

class CrowdSearch {
 public:
  CrowdSearch(const PointArrays& points, const GroupedPoints& groups, double ball_radius,
              WalkScratch& scratch)
      : points_(points),
        groups_(groups),
        p_{points.x[scratch.point], points.y[scratch.point], points.z[scratch.point]},
        inverse_(1.0 / ball_radius),
        scratch_(scratch) {}

  bool run() {
    constexpr int kRounds = 64;
    begin_near();
    const Vec3& normal = points_.normals[scratch_.point];
    for (int round = 0; round < kRounds; ++round) {
      put_in_list();
      if (ids_ < 3) return false;
      NeighbourList list{scratch_.neighbours, ids_, {normal.x, normal.y, normal.z}, scratch_.list};
      std::uint32_t near[kMostClipping];
      const std::uint32_t count = few_of(list.n, near);
      // Points may be as close together as the ends of arcs are known to.
      Clipping clipping(list, near, count, 0.0);
      const Clipping::Outcome outcome = clipping.run();
      scratch_.count = list.n;
      if (outcome != Clipping::Outcome::kClipped) return outcome == Clipping::Outcome::kNothingFree;
      ids_ = list.n;
      for (std::uint32_t k = 0; k < ids_; ++k) id_[k] = list.s.id[k];
      if (!add_reaching(clipping)) return true;
      if (ids_ > kMostIds) return false;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kMostNew = 512, kMostIds = 1024;
  static constexpr std::uint32_t kGroup = GroupedPoints::kGroup;

  /// What the neighbours found so far leave free.
  struct Free {
    const Clipping::Caps& caps;
    const FreeBoundary& boundary;
    FreeRegion region;
    bool enclosed;  // by the region
  };

  /// Points about as near as the nearest of those that come before and after this one in the
  /// groups.
  void begin_near() {
    constexpr std::uint32_t kBefore = kGroup, kLook = 3 * kGroup, kWanted = 14;
    const std::uint32_t at = groups_.place[scratch_.point] / kGroup * kGroup;
    const std::uint32_t first = at < kBefore ? 0 : at - kBefore;
    double nearest[kWanted];  // ascending
    std::uint32_t count_nearest = 0;
    for (std::uint32_t k = first; k < first + kLook && k < groups_.level[0].count; ++k) {
      const double squared = squared_distance(k);
      if (!(squared < 4.0 && squared > 0.0)) continue;
      if (count_nearest == kWanted && !(squared < nearest[kWanted - 1])) continue;
      std::uint32_t to = count_nearest < kWanted ? count_nearest++ : kWanted - 1;
      for (; to > 0 && nearest[to - 1] > squared; --to) nearest[to] = nearest[to - 1];
      nearest[to] = squared;
    }
    const double reach = count_nearest == 0 ? 4.0 : nearest[count_nearest - 1];
    const double up_to = reach * (1.0 + 1e-9);
    const int top = groups_.levels - 1;
    for (std::uint32_t k = 0; k < groups_.level[top].count; k += kGroup)
      take_within(up_to < 4.0 ? up_to : 4.0, top, k);
    sort_ids();
  }
  double squared_distance(std::uint32_t place) const {
    const GroupedPoints::Level& l = groups_.level[0];
    const double dx = (l.x[place] - p_.x) * inverse_, dy = (l.y[place] - p_.y) * inverse_,
                 dz = (l.z[place] - p_.z) * inverse_;
    return dx * dx + dy * dy + dz * dz;
  }
  void take_within(double squared_reach, int level, std::uint32_t first) {
    const GroupedPoints::Level& l = groups_.level[level];
    const Lanes px = Lanes::all(p_.x), py = Lanes::all(p_.y), pz = Lanes::all(p_.z);
    const Lanes inverse = Lanes::all(inverse_), zero = Lanes::all(0.0);
    const Lanes near = Lanes::all(std::sqrt(squared_reach));
    for (std::uint32_t k = first; k < first + kGroup; k += Lanes::kWidth) {
      const DirectionOf<Lanes> d = {(Lanes::load(l.x + k) - px) * inverse,
                                    (Lanes::load(l.y + k) - py) * inverse,
                                    (Lanes::load(l.z + k) - pz) * inverse};
      const Lanes squared = inner(d, d);
      const Lanes reach = near + Lanes::load(l.radius + k) * inverse;
      auto left = squared < reach * reach;
      if (level == 0) left = both(left, zero < squared);
      if (!any(left)) continue;
      std::uint32_t found[2 * Lanes::kWidth] = {};
      compress_store_indices(found, k, left);
      const std::uint32_t count_found = count(left);
      for (std::uint32_t f = 0; f < count_found && ids_ < kMostNew; ++f) {
        if (level > 0) {
          take_within(squared_reach, level - 1, found[f] * kGroup);
        } else {
          id_[ids_++] = groups_.id[found[f]];
        }
      }
    }
  }

  /// Fills the list of neighbours as gather() does.
  void put_in_list() {
    const Neighbours& to = scratch_.neighbours;
    for (std::uint32_t k = 0; k < ids_; ++k) {
      const std::uint32_t id = id_[k];
      const double dx = (points_.x[id] - p_.x) * inverse_, dy = (points_.y[id] - p_.y) * inverse_,
                   dz = (points_.z[id] - p_.z) * inverse_;
      const double squared = dx * dx + dy * dy + dz * dz;
      to.dx[k] = dx, to.dy[k] = dy, to.dz[k] = dz;
      to.cap_height[k] = squared * 0.5;
      to.inverse_length[k] = 1.0 / std::sqrt(to.cap_height[k] * 2.0);
      to.id[k] = id;
    }
    scratch_.count = ids_;
    NeighbourList{to, ids_, {}, nullptr}.end_list();
  }

  /// The nearest, to begin with.
  std::uint32_t few_of(std::uint32_t n, std::uint32_t* chosen) const {
    const NearCaps<kFewOfCrowd> near(scratch_.neighbours, n);
    for (std::uint32_t k = 0; k < near.size(); ++k) chosen[k] = near.index(k);
    return near.size();
  }

  /// Adds points whose caps reach into what is free. False: there are no others.
  bool add_reaching(const Clipping& clipping) {
    known_ = ids_;
    Free free{clipping.caps(), clipping.boundary(), {}, false};
    free.enclosed =
        free.boundary.enclose(free.region, [&](Direction u) { return free.caps.hold(u, kNobody); });
    const int top = groups_.levels - 1;
    for (std::uint32_t k = 0; k < groups_.level[top].count; k += kGroup) look_at(free, top, k);
    sort_ids();
    const bool added = ids_ > known_;
    known_ = 0;
    return added;
  }

  void look_at(const Free& free, int level, std::uint32_t first) {
    const GroupedPoints::Level& l = groups_.level[level];
    const Lanes px = Lanes::all(p_.x), py = Lanes::all(p_.y), pz = Lanes::all(p_.z);
    const Lanes inverse = Lanes::all(inverse_), half = Lanes::all(0.5), zero = Lanes::all(0.0);
    for (std::uint32_t k = first; k < first + kGroup; k += Lanes::kWidth) {
      const DirectionOf<Lanes> d = {(Lanes::load(l.x + k) - px) * inverse,
                                    (Lanes::load(l.y + k) - py) * inverse,
                                    (Lanes::load(l.z + k) - pz) * inverse};
      const Lanes radius = Lanes::load(l.radius + k) * inverse;
      const Lanes squared = inner(d, d);
      const Lanes reach = Lanes::all(2.0) + radius;
      auto left = squared < reach * reach;
      if (level == 0) left = both(left, zero < squared);
      if (!any(left)) continue;
      const Lanes height = half * squared;
      const Lanes most = height - radius - half * radius * radius - rounding_of(height);
      const Lanes length = square_root(squared);
      if (free.enclosed) left = but_not(left, free.region.stays_below(d, length, most, left));
      if (!any(left)) continue;
      auto apart = free.boundary.stays_below(d, most, left);
      if (any(apart)) apart = free.caps.hold_surely(scaled(Lanes::all(1.0) / length, d), apart);
      left = but_not(left, apart);
      if (!any(left)) continue;
      std::uint32_t found[2 * Lanes::kWidth] = {};
      compress_store_indices(found, k, left);
      const std::uint32_t count_found = count(left);
      for (std::uint32_t f = 0; f < count_found && ids_ < known_ + kMostNew; ++f) {
        if (level > 0) {
          look_at(free, level - 1, found[f] * kGroup);
        } else if (!is_known(groups_.id[found[f]])) {
          id_[ids_++] = groups_.id[found[f]];
        }
      }
    }
  }

  bool is_known(std::uint32_t id) const {
    std::uint32_t begin = 0, end = known_;
    while (begin < end) {
      const std::uint32_t middle = (begin + end) / 2;
      if (id_[middle] == id) return true;
      if (id_[middle] < id) {
        begin = middle + 1;
      } else {
        end = middle;
      }
    }
    return false;
  }
  void sort_ids() {
    constexpr std::uint32_t kGaps[] = {301, 132, 57, 23, 10, 4, 1};
    for (const std::uint32_t gap : kGaps) {
      for (std::uint32_t k = gap; k < ids_; ++k) {
        const std::uint32_t id = id_[k];
        std::uint32_t at = k;
        for (; at >= gap && id_[at - gap] > id; at -= gap) id_[at] = id_[at - gap];
        id_[at] = id;
      }
    }
  }

  const PointArrays& points_;
  const GroupedPoints& groups_;
  const Direction p_;
  const double inverse_;
  WalkScratch& scratch_;
  std::uint32_t id_[kMostOfCrowd];  // ascending
  std::uint32_t ids_ = 0, known_ = 0;
};

bool gather_crowd(const PointArrays& points, const GroupedPoints& groups, double ball_radius,
                  WalkScratch& scratch) {
  CrowdSearch search(points, groups, ball_radius, scratch);
  return search.run();
}
