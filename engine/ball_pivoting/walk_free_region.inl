// The balls at a point that its nearest neighbours leave empty, enclosed in a few spheres. A
// neighbour whose cap reaches into none of them has no part in what is found at the point, and one
// whose cap holds a sphere leaves nothing of it. Included by walk_kernel.inl.

/// Directions u with |u - center| <= radius.
struct Blob {
  Direction center;
  double radius;
};

inline Direction mean_of(Direction a, Direction b) { return scaled(0.5, a + b); }
inline double distance(Direction a, Direction b) {
  const Direction apart = a - b;
  return std::sqrt(inner(apart, apart));
}

/// The smallest sphere around two.
inline Blob around(const Blob& a, const Blob& b) {
  const double apart = distance(a.center, b.center);
  if (apart + b.radius <= a.radius) return a;
  if (apart + a.radius <= b.radius) return b;
  const double radius = 0.5 * (apart + a.radius + b.radius);
  return {a.center + scaled((radius - a.radius) / apart, b.center - a.center), radius};
}

class FreeRegion {
 public:
  static constexpr std::uint32_t kMostBlobs = 6;

  /// The point at a pseudo-angle of a circle.
  static Direction at_angle(const Circle& c, double angle) {
    const double turned = angle >= 4.0 ? angle - 4.0 : angle;
    const double cosine = turned < 2.0 ? 1.0 - turned : turned - 3.0;
    const double rest = 1.0 - cosine * cosine;
    const double sine = std::sqrt(rest > 0.0 ? rest : 0.0);
    return c.middle + scaled(cosine, c.a) + scaled(turned < 2.0 ? sine : -sine, c.b);
  }

  /// Adds a free arc. An arc lies in the triangle of its ends and of the point where its tangents
  /// there meet.
  void add(const Circle& c, double from, double to) {
    constexpr double kLongest = 1.8;  // below half a circle, which is 2
    if (!(to - from < kLongest)) known_ = false;
    if (!known_) return;
    const Direction first = at_angle(c, from), last = at_angle(c, to);
    const Direction e0 = first - c.middle, e1 = last - c.middle;
    const double square = inner(c.a, c.a), opening = square + inner(e0, e1);
    if (!(opening > 0.0)) {
      known_ = false;
      return;
    }
    add_triangle(first, last, c.middle + scaled(square / opening, e0 + e1));
  }
  void add_triangle(Direction first, Direction last, Direction tip) {
    constexpr double kRounding = 1e-7;
    if (!known_) return;
    Blob blob{mean_of(mean_of(first, last), tip), 0.0};
    const Direction corners[] = {first, last, tip};
    for (const Direction& corner : corners) {
      const double away = distance(blob.center, corner);
      if (away > blob.radius) blob.radius = away;
    }
    blob.radius += kRounding;
    insert(blob);
  }
  void forget() { known_ = false; }

  /// The boundary of the free region lies in the blobs, which are apart: what is outside of them
  /// all is free or covered as a whole. `is_covered`: tells of a direction.
  template <class IsCovered>
  bool encloses_all(const IsCovered& is_covered) const {
    if (!known_) return false;
    const Direction probes[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    for (const Direction& probe : probes) {
      bool outside = true;
      for (std::uint32_t b = 0; b < count_; ++b)
        outside = outside && distance(probe, blobs_[b].center) > blobs_[b].radius;
      if (outside) return is_covered(probe);
    }
    return false;
  }

  /// Leaves out blobs that a neighbour's cap holds; that neighbour stays relevant.
  void drop_covered(const Neighbours& list, std::uint32_t n) {
    for (std::uint32_t b = 0; b < count_;) {
      const std::uint32_t cover = first_cover(blobs_[b], list, n);
      if (cover == kNobody) {
        ++b;
      } else {
        covers_[cover_count_++] = static_cast<double>(cover);
        blobs_[b] = blobs_[--count_];
      }
    }
  }
  bool empty() const { return count_ == 0; }

  /// Lanes where u.d is below `most` for all directions u of the blobs; `length` is that of d.
  Lanes::Mask stays_below(DirectionOf<Lanes> d, Lanes length, Lanes most,
                          Lanes::Mask wanted) const {
    for (std::uint32_t b = 0; b < count_; ++b) {
      const BlobLanes blob(blobs_[b]);
      wanted = both(wanted, inner(blob.center, d) + blob.radius * length < most);
    }
    return wanted;
  }

  /// Lists the neighbours whose caps reach into a blob or hold one, in order; `listed` has room for
  /// n and a vector more.
  std::uint32_t list_relevant(const Neighbours& list, std::uint32_t n,
                              std::uint32_t* listed) const {
    std::uint32_t count_listed = 0;
    for (std::uint32_t k = 0; k < n; k += Lanes::kWidth) {
      const Lanes height = Lanes::load(list.cap_height + k);
      auto apart = first_lanes(n - k);
      for (std::uint32_t b = 0; b < count_; ++b) {
        const BlobLanes blob(blobs_[b]);
        apart = both(apart, blob.depth(list, k, height) < Lanes::all(0.0) - blob.reach(height));
      }
      for (std::uint32_t c = 0; c < cover_count_; ++c)
        apart =
            but_not(apart, Lanes::counting_from(static_cast<double>(k)) == Lanes::all(covers_[c]));
      const auto relevant = but_not(first_lanes(n - k), apart);
      compress_store_indices(listed + count_listed, k, relevant);
      count_listed += count(relevant);
    }
    return count_listed;
  }

 private:
  struct BlobLanes {
    DirectionOf<Lanes> center;
    Lanes radius;
    explicit BlobLanes(const Blob& b)
        : center{Lanes::all(b.center.x), Lanes::all(b.center.y), Lanes::all(b.center.z)},
          radius{Lanes::all(b.radius)} {}
    /// How deep the blob's centre lies in the caps, times the neighbours' distance.
    Lanes depth(const Neighbours& list, std::uint32_t k, Lanes height) const {
      return center.x * Lanes::load(list.dx + k) + center.y * Lanes::load(list.dy + k) +
             center.z * Lanes::load(list.dz + k) - height;
    }
    /// What a point of the blob may differ by from that.
    Lanes reach(Lanes height) const {
      return radius * square_root(height * Lanes::all(2.0)) + Lanes::all(1e-12);
    }
  };

  /// The first neighbour whose cap holds the blob.
  static std::uint32_t first_cover(const Blob& of, const Neighbours& list, std::uint32_t n) {
    const BlobLanes blob(of);
    for (std::uint32_t k = 0; k < n; k += Lanes::kWidth) {
      const Lanes height = Lanes::load(list.cap_height + k);
      const auto covers =
          both(first_lanes(n - k), blob.reach(height) < blob.depth(list, k, height));
      if (!any(covers)) continue;
      std::uint32_t found[2 * Lanes::kWidth];
      compress_store_indices(found, k, covers);
      return found[0];
    }
    return kNobody;
  }

  void insert(Blob blob) {
    constexpr double kLargest = 0.8;
    for (std::uint32_t b = 0; b < count_;) {
      if (distance(blob.center, blobs_[b].center) > blob.radius + blobs_[b].radius) {
        ++b;
        continue;
      }
      blob = around(blob, blobs_[b]);
      blobs_[b] = blobs_[--count_];
      b = 0;  // the larger one may overlap others
    }
    if (count_ == kMostBlobs || blob.radius > kLargest) {
      known_ = false;
      return;
    }
    blobs_[count_++] = blob;
  }

  Blob blobs_[kMostBlobs];
  std::uint32_t count_ = 0;
  double covers_[kMostBlobs];  // neighbours that hold a blob
  std::uint32_t cover_count_ = 0;
  bool known_ = true;
};
