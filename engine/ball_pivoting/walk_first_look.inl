// The first look at a point when further radii are tried: which triangles there may be among active
// points, before they are held against all. Included by walk_kernel.inl.

/// Whether there are two wanted neighbours. Those behind the point are the last of the list.
bool Walker::wants_two(const std::uint8_t* active) const {
  std::uint32_t wanted = 0;
  for (std::uint32_t k = n_; k > 0 && wanted < 2 && s_.id[k - 1] > scratch_.point; --k)
    wanted += is_wanted(k - 1, active) ? 1 : 0;
  return wanted == 2;
}

/// Lists the wanted neighbours whose circles no single cap of the nearest covers; returns their
/// number. Most circles of a large ball are covered like that.
std::uint32_t Walker::list_uncovered(const NearestCaps& near, const std::uint8_t* active) const {
  std::uint32_t listed = 0;
  for (std::uint32_t first = 0; first < n_; first += Lanes::kWidth) {
    const std::uint32_t end = n_ - first < Lanes::kWidth ? n_ : first + Lanes::kWidth;
    if (!(s_.id[end - 1] > scratch_.point)) continue;
    const DirectionOf<Lanes> d = {Lanes::load(s_.dx + first), Lanes::load(s_.dy + first),
                                  Lanes::load(s_.dz + first)};
    const auto left =
        near.leave_circle_free(d, Lanes::load(s_.cap_height + first), first_lanes(n_ - first));
    if (!any(left)) continue;
    std::uint32_t found[2 * Lanes::kWidth] = {};
    compress_store_indices(found, first, left);
    const std::uint32_t count_found = count(left);
    for (std::uint32_t f = 0; f < count_found; ++f)
      if (is_wanted(found[f], active)) scratch_.list[listed++] = found[f];
  }
  return listed;
}

/// Leaves those in the list whose circles may run through one of the cells; returns their number.
std::uint32_t Walker::keep_listed(const FreeCells& cells, std::uint32_t listed) const {
  std::uint32_t* const list = scratch_.list;
  std::uint32_t kept = 0;
  double x[Lanes::kWidth], y[Lanes::kWidth], z[Lanes::kWidth], height[Lanes::kWidth];
  for (std::uint32_t first = 0; first < listed; first += Lanes::kWidth) {
    const std::uint32_t some = listed - first < Lanes::kWidth ? listed - first : Lanes::kWidth;
    for (std::uint32_t lane = 0; lane < Lanes::kWidth; ++lane) {
      const std::uint32_t k = list[lane < some ? first + lane : first];
      x[lane] = s_.dx[k], y[lane] = s_.dy[k], z[lane] = s_.dz[k], height[lane] = s_.cap_height[k];
    }
    const auto met = cells.met_by({Lanes::load(x), Lanes::load(y), Lanes::load(z)},
                                  Lanes::load(height), first_lanes(some));
    for (std::uint32_t lane = 0; lane < some; ++lane)
      if (any(both(met, lane_mask(lane)))) list[kept++] = list[first + lane];
  }
  return kept;
}

/// Whether a ball holds any of the neighbours beyond doubt.
bool Walker::is_held(Direction u) const {
  const DirectionOf<Lanes> at = {Lanes::all(u.x), Lanes::all(u.y), Lanes::all(u.z)};
  for (std::uint32_t k = 0; k < n_; k += Lanes::kWidth) {
    const DirectionOf<Lanes> d = {Lanes::load(s_.dx + k), Lanes::load(s_.dy + k),
                                  Lanes::load(s_.dz + k)};
    if (any(beyond_doubt(Lanes::load(s_.cap_height + k)) < inner(at, d))) return true;
  }
  return false;
}

/// All corners of active points that there may be.
void Walker::suspect(const std::uint8_t* active, const Corner* taken, std::uint32_t taken_count) {
  fan_.count = 0;
  fan_.closed = fan_.blocked = false;
  if (!wants_two(active)) return;
  NearestCaps near(s_, n_);
  std::uint32_t listed = list_uncovered(near, active);
  if (listed >= kManyListed) {
    invert_lengths(scratch_, n_);
    leave_out_irrelevant();
    if (nothing_free_) {
      fan_.blocked = true;
      return;
    }
    near = NearestCaps(s_, n_);
    listed = list_uncovered(near, active);
  } else if (listed >= kSomeListed) {
    const FreeCells cells(near);
    fan_.blocked = cells.empty();
    listed = cells.empty() ? 0 : keep_listed(cells, listed);
  }
  if (listed < 2) return;
  if (listed <= Partners::kMost) {
    const std::uint32_t most = corner_bound(scratch_.count);
    bool too_many = false;
    Partners partners(points_, s_, taken, taken_count);
    for (std::uint32_t l = 0; l < listed; ++l) partners.add(scratch_.list[l]);
    partners.end_list();
    partners.for_each_pair(normal_, near,
                           [&](std::uint32_t i, std::uint32_t j, Direction u, bool sure) {
                             if (sure && is_held(u)) return;
                             if (fan_.count == most) too_many = true;
                             if (!too_many) emit(i, j);
                           });
    if (!too_many) return;
  }
  fan_.count = 0;
  if (!clipped_) invert_lengths(scratch_, n_);
  scan_all(active);
}
