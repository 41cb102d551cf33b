#include "io/clouds/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "io/vec3_order.h"

namespace orbweave {
namespace {

constexpr double kWeek = 604'800.0;
/// What LAS takes from the seconds of GPS since 1980 (LAS 1.4 R15, adjusted standard GPS time).
constexpr double kAdjustment = 1e9;
/// Names of the time of a point, from the most certain on.
constexpr std::array<std::string_view, 4> kTimes = {"gps_time", "time", "timestamp", "t"};

/// Seconds of GPS since 1980 from such with or without the adjustment: there were a billion in
/// 2011.
double since_1980(double time) { return time < kAdjustment ? time + kAdjustment : time; }

/// Whether a clock counts the seconds of a week; a path may run into the next one.
bool is_of_week(double first, double last) { return first >= 0.0 && last < 2.0 * kWeek; }

}  // namespace

Trajectory::Trajectory(std::vector<Place> places) : places_(std::move(places)) {
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    return a.time != b.time ? a.time < b.time : comes_before(a.position, b.position);
  });
  const auto is_same = [](const Place& a, const Place& b) { return a.time == b.time; };
  places_.erase(std::unique(places_.begin(), places_.end(), is_same), places_.end());
  double way = 0.0;
  std::vector<double> speeds;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    bounds_.extend(places_[i].position);
    if (i == 0) continue;
    const double step = norm(places_[i].position - places_[i - 1].position);
    way += step;
    speeds.push_back(step / (places_[i].time - places_[i - 1].time));
  }
  const auto middle = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() / 2);
  std::nth_element(speeds.begin(), middle, speeds.end());
  speed_ = *middle;
  constexpr double kSteps = 8.0;
  const auto steps = static_cast<double>(speeds.size());
  longest_ = kSteps * (last_time() - first_time()) / steps;
  farthest_ = kSteps * way / steps;
  // As many slices as places: a search looks at one of them.
  slice_begin_.assign(places_.size() + 1, 0);
  for (const Place& place : places_) ++slice_begin_[slice_of(place.time) + 1];
  std::partial_sum(slice_begin_.begin(), slice_begin_.end(), slice_begin_.begin());
}

/// Rounding moves a time to the slice beside the same way for places and for what is looked for.
std::size_t Trajectory::slice_of(double time) const {
  const double share = (time - first_time()) / (last_time() - first_time());
  const auto count = static_cast<double>(places_.size());
  return static_cast<std::size_t>(std::clamp(share * count, 0.0, count - 1.0));
}

std::optional<Vec3> Trajectory::at(double time) const {
  if (!std::isfinite(time)) return std::nullopt;
  if (std::optional<Vec3> place = on_path(time)) return place;
  if (is_of_week(first_time(), last_time())) {
    const double of_week = std::fmod(since_1980(time), kWeek);
    std::optional<Vec3> place = on_path(of_week);
    return place ? place : on_path(of_week + kWeek);
  }
  if (is_of_week(time, time)) {
    const double first = since_1980(first_time());
    const double week = first - std::fmod(first, kWeek);
    return on_path(week + time - (first - first_time()));
  }
  const std::optional<Vec3> place = on_path(time + kAdjustment);
  return place ? place : on_path(time - kAdjustment);
}

std::optional<Vec3> Trajectory::on_path(double time) const {
  if (time > last_time())
    return time - last_time() <= longest_ ? std::optional(places_.back().position) : std::nullopt;
  if (time <= first_time())
    return first_time() - time <= longest_ ? std::optional(places_.front().position) : std::nullopt;
  const std::size_t slice = slice_of(time);
  const auto begin = places_.begin() + slice_begin_[slice];
  // Where no place of the slice is as late, the first one behind it is.
  const auto next = std::lower_bound(begin, places_.begin() + slice_begin_[slice + 1], time,
                                     [](const Place& place, double t) { return place.time < t; });
  if (time == next->time) return next->position;  // to the last digit
  const Place& from = *(next - 1);
  if (!is_bridged(from, *next)) return std::nullopt;
  const double share = (time - from.time) / (next->time - from.time);
  return from.position + share * (next->position - from.position);
}

/// What was left out of a path where the scanner went straight is known; between two flight lines
/// it was elsewhere, and the way from one to the other is short for the time.
bool Trajectory::is_bridged(const Place& from, const Place& to) const {
  constexpr double kStraight = 0.5;  // of the way at the usual speed
  const double time = to.time - from.time;
  const double way = norm(to.position - from.position);
  return time <= longest_ || way <= farthest_ || way >= kStraight * speed_ * time;
}

bool names_time(std::string_view name) {
  return std::ranges::any_of(kTimes,
                             [&](std::string_view time) { return have_same_name(name, time); });
}

std::optional<NamedAttribute> find_time(const PointSchema& schema) {
  for (const std::string_view name : kTimes)
    if (std::optional<NamedAttribute> time = find_attribute(schema, name)) return time;
  return std::nullopt;
}

}  // namespace orbweave
