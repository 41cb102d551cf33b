// Where a scanner that moved was at each time: the path of a vehicle, of an aircraft, or of a
// scanner that was carried by hand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "io/box.h"
#include "io/point_cloud.h"
#include "io/points/named_attribute.h"

namespace orbweave {

/// The path of a scanner, which moves evenly from each place to the next one.
class Trajectory {
 public:
  struct Place {
    double time = 0.0;  ///< seconds of any clock, the same for all places
    Vec3 position;      ///< world coordinates
  };

  /// `places`: finite, in any order, at two times at least; of several at one time the first by its
  /// coordinates counts.
  explicit Trajectory(std::vector<Place> places);

  /// Where the scanner was. Nothing at times that the path does not cover: more than 8 mean steps
  /// before its first or behind its last place, or in a gap as long, unless the scanner hardly
  /// moved meanwhile, or went on straight at its usual speed. Where the path counts the seconds of
  /// a week and `time` those of GPS, with or without the billion that LAS takes away, or the other
  /// way round, both are taken for the same clock.
  std::optional<Vec3> at(double time) const;

  double first_time() const { return places_.front().time; }
  double last_time() const { return places_.back().time; }
  const Box& bounds() const { return bounds_; }

 private:
  std::optional<Vec3> on_path(double time) const;
  std::size_t slice_of(double time) const;
  bool is_bridged(const Place& from, const Place& to) const;

  std::vector<Place> places_;               // ascending by time, each time once
  std::vector<std::uint32_t> slice_begin_;  // first places of even slices of time, and their end
  Box bounds_;
  double longest_ = 0.0;   // time without a place that is covered
  double farthest_ = 0.0;  // way without a place that is covered
  double speed_ = 0.0;     // of most steps
};

/// The attribute that tells when a point was measured: gps_time, time, timestamp or t.
std::optional<NamedAttribute> find_time(const PointSchema& schema);
/// Whether an attribute of that name does so.
bool names_time(std::string_view name);

}  // namespace orbweave
