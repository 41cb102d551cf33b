// Cells of the sphere of directions that no single cap of the nearest neighbours holds: a coarse
// picture of what is free, at little cost. A neighbour whose circle runs through none of these
// cells has no part in what is found. Included by walk_kernel.inl.

/// Tangents of the middles of equal parts of 45 degrees.
template <std::uint32_t kParts>
inline constexpr double kTangents[kParts] = {};
template <>
inline constexpr double kTangents<2>[] = {0.198912367379658, 0.6681786379192989};
template <>
inline constexpr double kTangents<4>[] = {0.09849140335716425, 0.3033466836073424,
                                          0.5345111359507916, 0.8206787908286602};

constexpr double constant_square_root(double a) {
  double root = a;
  for (int round = 0; round < 32; ++round) root = 0.5 * (root + a / root);
  return root;
}

/// Middles of cells: planes through the centre of a cube, at equal angles, cut each face of the
/// cube into kSide by kSide cells. With twice as many planes cell c falls into the cells 4 c to
/// 4 c + 3.
template <std::uint32_t kSide>
struct CellMiddles {
  static constexpr std::uint32_t kCount = 6 * kSide * kSide;
  double x[kCount] = {}, y[kCount] = {}, z[kCount] = {};

  constexpr CellMiddles() {
    for (std::uint32_t cell = 0; cell < kCount; ++cell) {
      const std::uint32_t face = cell / (kSide * kSide), axis = face / 2;
      std::uint32_t s = 0, t = 0;  // places of the cell on its face
      for (std::uint32_t bit = 0; (1u << bit) < kSide; ++bit) {
        s |= (cell >> (2 * bit) & 1u) << bit;
        t |= (cell >> (2 * bit + 1) & 1u) << bit;
      }
      const double u = tangent(s), v = tangent(t);
      const double inverse = 1.0 / constant_square_root(1.0 + u * u + v * v);
      const double along[] = {face % 2 == 0 ? inverse : -inverse, u * inverse, v * inverse};
      x[cell] = along[axis];
      y[cell] = along[(axis + 1) % 3];
      z[cell] = along[(axis + 2) % 3];
    }
  }

  DirectionOf<Lanes> at(std::uint32_t cell) const {
    return {Lanes::load(x + cell), Lanes::load(y + cell), Lanes::load(z + cell)};
  }

 private:
  static constexpr double tangent(std::uint32_t place) {
    constexpr std::uint32_t kHalf = kSide / 2;
    return place < kHalf ? -kTangents<kHalf>[kHalf - 1 - place] : kTangents<kHalf>[place - kHalf];
  }
};

/// The cells that no single cap holds whole: coarse cells first, then the four parts of each that
/// is left.
class FreeCells {
 public:
  explicit FreeCells(const NearestCaps& caps) {
    std::uint32_t coarse[kCoarse.kCount + Lanes::kWidth];
    std::uint32_t coarse_count = 0;
    double holding[NearestCaps::kRoom];
    caps.list_holding(kCoarseRadius, holding);
    for (std::uint32_t cell = 0; cell < kCoarse.kCount; cell += Lanes::kWidth) {
      const auto free = caps.leave_cells_free(kCoarse.at(cell), holding);
      compress_store_indices(coarse + coarse_count, cell, free);
      coarse_count += count(free);
    }
    caps.list_holding(kRadius, holding);
    const std::uint32_t parts = kParts * coarse_count;
    for (std::uint32_t first = 0; first < parts; first += Lanes::kWidth) {
      double x[Lanes::kWidth], y[Lanes::kWidth], z[Lanes::kWidth];
      for (std::uint32_t lane = 0; lane < Lanes::kWidth; ++lane) {
        const std::uint32_t part = first + lane < parts ? first + lane : first;
        const std::uint32_t cell = kParts * coarse[part / kParts] + part % kParts;
        x[lane] = kFine.x[cell], y[lane] = kFine.y[cell], z[lane] = kFine.z[cell];
      }
      const DirectionOf<Lanes> middle = {Lanes::load(x), Lanes::load(y), Lanes::load(z)};
      const auto free = both(first_lanes(parts - first), caps.leave_cells_free(middle, holding));
      compress_store(x_ + n_, middle.x, free);
      compress_store(y_ + n_, middle.y, free);
      compress_store(z_ + n_, middle.z, free);
      n_ += count(free);
    }
  }

  bool empty() const { return n_ == 0; }

  /// Lanes of neighbours whose circles may run through a cell.
  Lanes::Mask met_by(DirectionOf<Lanes> d, Lanes height, Lanes::Mask wanted) const {
    const Lanes zero = Lanes::all(0.0);
    const Lanes reach = NearestCaps::reach_of_cell(kRadius, height);
    auto left = wanted;
    for (std::uint32_t c = 0; c < n_ && any(left); ++c) {
      const DirectionOf<Lanes> middle = {Lanes::all(x_[c]), Lanes::all(y_[c]), Lanes::all(z_[c])};
      const Lanes away = inner(middle, d) - height;
      left = but_not(left, larger(away, zero - away) < reach);
    }
    return but_not(wanted, left);
  }

 private:
  static constexpr CellMiddles<4> kCoarse{};
  static constexpr CellMiddles<8> kFine{};
  /// Bounds on the distance of a cell's directions from the cell's middle (0.28531 and 0.15065),
  /// and more than the 1e-5 that beyond_doubt() leaves for rounding.
  static constexpr double kCoarseRadius = 0.2854, kRadius = 0.1507;
  static constexpr std::uint32_t kParts = 4;  ///< of a coarse cell

  double x_[kFine.kCount + Lanes::kWidth], y_[kFine.kCount + Lanes::kWidth],
      z_[kFine.kCount + Lanes::kWidth];
  std::uint32_t n_ = 0;
};
