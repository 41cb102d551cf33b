// The boundary of the directions that some caps leave free. Included by walk_kernel.inl.

/// Arcs of circles, in pieces. A piece lies in the triangle of its ends and of the point where the
/// tangents there meet.
class FreeBoundary {
 public:
  /// Adds an arc. Where there are too many pieces not all is known.
  void add(const Circle& c, double from, double to) {
    constexpr double kLongest = 0.5;
    const auto pieces = static_cast<std::uint32_t>((to - from) / kLongest) + 1;
    if (count_ + pieces > kMost) known_ = false;
    if (!known_) return;
    const double step = (to - from) / pieces;
    Direction first = FreeRegion::at_angle(c, from);
    for (std::uint32_t piece = 1; piece <= pieces; ++piece) {
      const Direction last = FreeRegion::at_angle(c, piece == pieces ? to : from + piece * step);
      const Direction e0 = first - c.middle, e1 = last - c.middle;
      const double square = inner(c.a, c.a), opening = square + inner(e0, e1);
      if (!(opening > 0.0)) known_ = false;
      begin_[count_] = first;
      end_[count_] = last;
      tip_[count_++] = c.middle + scaled(square / opening, e0 + e1);
      first = last;
    }
  }
  bool known() const { return known_; }
  bool empty() const { return count_ == 0; }
  std::uint32_t pieces() const { return count_; }
  Direction end(std::uint32_t piece) const { return end_[piece]; }

  /// Spheres that enclose what is free, where there are such: what is outside of them all is
  /// covered.
  template <class IsCovered>
  bool enclose(FreeRegion& region, const IsCovered& is_covered) const {
    for (std::uint32_t p = 0; p < count_; ++p) region.add_triangle(begin_[p], end_[p], tip_[p]);
    return region.encloses_all(is_covered);
  }
  void clear() {
    count_ = 0;
    known_ = true;
  }

  /// Lanes where u.d is below `most` for all directions u of the pieces.
  Lanes::Mask stays_below(DirectionOf<Lanes> d, Lanes most, Lanes::Mask wanted) const {
    auto left = wanted;
    for (std::uint32_t p = 0; p < count_ && any(left); ++p) {
      const Lanes furthest =
          larger(larger(along(begin_[p], d), along(tip_[p], d)), along(end_[p], d));
      left = both(left, furthest < most);
    }
    return left;
  }

 private:
  static constexpr std::uint32_t kMost = 128;
  static Lanes along(Direction u, DirectionOf<Lanes> d) {
    return Lanes::all(u.x) * d.x + Lanes::all(u.y) * d.y + Lanes::all(u.z) * d.z;
  }

  Direction begin_[kMost], tip_[kMost], end_[kMost];
  std::uint32_t count_ = 0;
  bool known_ = true;
};
