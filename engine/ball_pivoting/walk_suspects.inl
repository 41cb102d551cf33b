// Which triangles there may be among active points, at little cost for each pair of neighbours. The
// ball of most pairs holds one of the nearest neighbours, and not just so. Those that are left are
// held against all points afterwards. Included by walk_kernel.inl.

/// By how much more than its cap's height a neighbour has to be held for a ball to hold it beyond
/// doubt: centres of balls are known to a tenth of that.
inline Lanes beyond_doubt(Lanes height) {
  return height + Lanes::all(1e-5) * square_root(height + height) + Lanes::all(1e-12);
}

/// Some of the nearest neighbours, at most kMost.
class NearestCaps {
  static constexpr std::uint32_t kMost = 2 * kFew;

 public:
  static constexpr std::uint32_t kRoom = kMost + Lanes::kWidth;

  NearestCaps(const Neighbours& all, std::uint32_t n) {
    if (n <= kMost) {
      for (; n_ < n; ++n_) take(all, n_, n_);
    } else {
      const NearCaps<kFew> near(all, n);
      for (; n_ < near.size(); ++n_) take(all, near.index(n_), n_);
    }
    for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth)
      beyond_doubt(Lanes::load(height_ + k)).store(clear_ + k);
  }

  /// Lanes whose whole circle no single one of these caps surely covers: where E > sqrt(A^2 + B^2)
  /// by more than rounding (see walk_kernel.inl), without the root.
  Lanes::Mask leave_circle_free(DirectionOf<Lanes> d, Lanes height, Lanes::Mask wanted) const {
    const Lanes half = Lanes::all(0.5), one = Lanes::all(1.0), two = Lanes::all(2.0);
    const Lanes squared_radius = one - half * height;
    const Lanes inverse_square = half / height;  // of |d|
    for (std::uint32_t k = 0; k < n_ && any(wanted); ++k) {
      const Lanes cap_height = Lanes::all(height_[k]);
      const Lanes along = inner(d, at(k));
      const Lanes e = half * along - cap_height;
      const Lanes across = two * cap_height - along * along * inverse_square;
      const auto covered =
          both(Lanes::all(0.0) < e, squared_radius * across + Lanes::all(kDoubt) < e * e);
      wanted = but_not(wanted, covered);
    }
    return wanted;
  }

  /// Lanes whose direction one of these caps holds beyond doubt.
  Lanes::Mask hold(DirectionOf<Lanes> u, Lanes::Mask wanted) const {
    auto free = wanted;
    for (std::uint32_t k = 0; k < n_ && any(free); ++k)
      free = but_not(free, Lanes::all(clear_[k]) < inner(u, at(k)));
    return but_not(wanted, free);
  }

  /// By how much u.d of the directions u of a cell may differ from that of the cell's middle.
  /// `radius`: no direction of the cell is further from the middle.
  static Lanes reach_of_cell(double radius, Lanes height) {
    return Lanes::all(radius) * square_root(height + height) + Lanes::all(1e-12);
  }
  /// Per cap, what u.d has to exceed at a cell's middle u for the cap to hold the cell.
  void list_holding(double radius, double* holding) const {
    for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
      const Lanes height = Lanes::load(height_ + k);
      (height + reach_of_cell(radius, height)).store(holding + k);
    }
  }
  /// Lanes whose cells no single one of these caps holds. `holding`: see list_holding().
  Lanes::Mask leave_cells_free(DirectionOf<Lanes> middle, const double* holding) const {
    auto free = first_lanes(Lanes::kWidth);
    for (std::uint32_t k = 0; k < n_ && any(free); ++k)
      free = but_not(free, Lanes::all(holding[k]) < inner(middle, at(k)));
    return free;
  }

 private:
  /// Far more than what rounding makes of squares of lengths below 2.
  static constexpr double kDoubt = 1e-10;

  void take(const Neighbours& all, std::uint32_t from, std::uint32_t to) {
    x_[to] = all.dx[from], y_[to] = all.dy[from], z_[to] = all.dz[from];
    height_[to] = all.cap_height[from];
  }
  DirectionOf<Lanes> at(std::uint32_t k) const {
    return {Lanes::all(x_[k]), Lanes::all(y_[k]), Lanes::all(z_[k])};
  }

  std::uint32_t n_ = 0;
  double x_[kRoom], y_[kRoom], z_[kRoom], height_[kRoom] = {}, clear_[kRoom];
};

/// Neighbours with which triangles are looked for, side by side.
class Partners {
 public:
  static constexpr std::uint32_t kMost = 96;

  /// `taken`: corners of triangles that there are at the point.
  Partners(const PointArrays& points, const Neighbours& s, const Corner* taken,
           std::uint32_t taken_count)
      : points_(points), s_(s), taken_(taken), taken_count_(taken_count) {}

  /// Adds a neighbour, at most kMost of them, unless both edges to it are taken.
  void add(std::uint32_t k) {
    bool out = true, back = true;
    for (std::uint32_t t = 0; t < taken_count_; ++t) {
      out = out && first_of(taken_[t]) != s_.id[k];
      back = back && second_of(taken_[t]) != s_.id[k];
    }
    if (!out && !back) return;
    const Vec3& normal = points_.normals[s_.id[k]];
    d_.x[n_] = s_.dx[k], d_.y[n_] = s_.dy[k], d_.z[n_] = s_.dz[k];
    cap_height_[n_] = s_.cap_height[k];
    normal_.x[n_] = normal.x, normal_.y[n_] = normal.y, normal_.z[n_] = normal.z;
    out_[n_] = out ? 1.0 : 0.0;
    back_[n_] = back ? 1.0 : 0.0;
    index_[n_++] = k;
  }
  void end_list() {
    for (std::uint32_t l = n_; l < n_ + Lanes::kWidth; ++l) {
      d_.x[l] = d_.y[l] = d_.z[l] = 0.0;
      cap_height_[l] = 1.0;
      normal_.x[l] = normal_.y[l] = normal_.z[l] = 0.0;
      out_[l] = back_[l] = 0.0;
    }
  }

  /// Calls visit(i, j, u, sure) for pairs whose triangle agrees with the three normals and has no
  /// taken edge at the point, unless one of the caps surely holds the ball on the positive side.
  /// The ball is centred at u; where rounding makes u doubtful, `sure` is false.
  template <class Visit>
  void for_each_pair(Direction normal, const NearestCaps& caps, const Visit& visit) const {
    for (std::uint32_t i = 0; i + 1 < n_; ++i) {
      for (std::uint32_t first = i + 1; first < n_; first += Lanes::kWidth)
        test(i, first, normal, caps, visit);
    }
  }

 private:
  struct Array {
    double x[kMost + Lanes::kWidth], y[kMost + Lanes::kWidth], z[kMost + Lanes::kWidth];
    DirectionOf<Lanes> at(std::uint32_t k) const {
      return {Lanes::load(x + k), Lanes::load(y + k), Lanes::load(z + k)};
    }
    DirectionOf<Lanes> all_at(std::uint32_t k) const {
      return {Lanes::all(x[k]), Lanes::all(y[k]), Lanes::all(z[k])};
    }
  };

  template <class Visit>
  void test(std::uint32_t i, std::uint32_t first, Direction normal, const NearestCaps& caps,
            const Visit& visit) const {
    const Lanes zero = Lanes::all(0.0), one = Lanes::all(1.0);
    const DirectionOf<Lanes> di = d_.all_at(i), dj = d_.at(first);
    const DirectionOf<Lanes> across = outer(di, dj);
    const DirectionOf<Lanes> own = {Lanes::all(normal.x), Lanes::all(normal.y),
                                    Lanes::all(normal.z)};
    const Lanes at_p = inner(across, own), at_i = inner(across, normal_.all_at(i)),
                at_j = inner(across, normal_.at(first));
    const auto positive = both(both(zero < Lanes::all(out_[i]), zero < Lanes::load(back_ + first)),
                               both(zero < at_p, both(zero < at_i, zero < at_j)));
    const auto negative = both(both(zero < Lanes::all(back_[i]), zero < Lanes::load(out_ + first)),
                               both(at_p < zero, both(at_i < zero, at_j < zero)));
    auto left = both(first_lanes(n_ - first), either(positive, negative));
    if (!any(left)) return;
    const Lanes hi = Lanes::all(cap_height_[i]), hj = Lanes::load(cap_height_ + first);
    const Lanes square = inner(across, across);
    const Lanes inverse = one / square;
    const DirectionOf<Lanes> u1 = outer(dj, across), u2 = outer(across, di);
    const DirectionOf<Lanes> centre = {(hi * u1.x + hj * u2.x) * inverse,
                                       (hi * u1.y + hj * u2.y) * inverse,
                                       (hi * u1.z + hj * u2.z) * inverse};
    const Lanes rest = one - inner(centre, centre);
    const auto known = Lanes::all(kLeastSine * kLeastSine * 4.0) * hi * hj < square;
    left = but_not(left, both(known, rest < Lanes::all(-kLeastRest)));
    if (!any(left)) return;
    const auto sure = both(both(left, known), Lanes::all(kLeastRest) < rest);
    const Lanes height = square_root(at_least_zero(rest) * inverse);
    const DirectionOf<Lanes> u = centre + scaled(choose(positive, height, zero - height), across);
    left = but_not(left, caps.hold(u, sure));
    if (!any(left)) return;
    report(i, first, left, positive, sure, u, visit);
  }

  template <class Visit>
  void report(std::uint32_t i, std::uint32_t first, Lanes::Mask left, Lanes::Mask positive,
              Lanes::Mask sure, DirectionOf<Lanes> u, const Visit& visit) const {
    double x[Lanes::kWidth], y[Lanes::kWidth], z[Lanes::kWidth];
    u.x.store(x), u.y.store(y), u.z.store(z);
    for (std::uint32_t lane = 0; lane < Lanes::kWidth && first + lane < n_; ++lane) {
      const auto one = lane_mask(lane);
      if (!any(both(left, one))) continue;
      const std::uint32_t a = index_[i], b = index_[first + lane];
      const bool forward = any(both(positive, one));
      visit(forward ? a : b, forward ? b : a, Direction{x[lane], y[lane], z[lane]},
            any(both(sure, one)));
    }
  }

  /// Of the angle between two neighbours, and of the square of a ball's height over a triangle,
  /// both in ball radii: beyond these the centre of the ball is known to a millionth.
  static constexpr double kLeastSine = 1e-3, kLeastRest = 1e-6;

  const PointArrays& points_;
  const Neighbours& s_;
  const Corner* taken_;
  const std::uint32_t taken_count_;
  std::uint32_t n_ = 0;
  std::uint32_t index_[kMost];  // of the neighbour
  Array d_, normal_;
  /// Not 0 where the directed edge to the neighbour, or back from it, has no triangle.
  double out_[kMost + Lanes::kWidth], back_[kMost + Lanes::kWidth];
  double cap_height_[kMost + Lanes::kWidth];
};
