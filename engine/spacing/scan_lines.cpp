#include "engine/spacing/scan_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "engine/geometry/symmetric_eigen.h"
#include "engine/spacing/neighbor_spread.h"
#include "engine/spacing/site_points.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// A point and that many nearest others lie on a line where the variance beside their longest axis
/// is at most that part of the variance along it. Of seven points anywhere on a surface hardly any
/// do. More of them tell a line in spite of noise, where the lines beside are farther away.
constexpr std::array<std::size_t, 2> kOnLine = {6, 12};
constexpr double kMostBeside = 0.05;
constexpr std::size_t kFirstLook = 1024, kMostPlaces = 4096;
constexpr std::size_t kPlacesAtOnce = 64;
/// What is farther away, in distances between the points on a line, is of no line beside it.
constexpr double kMostApart = 64.0;

/// Every so many places of the sample, all over it.
std::vector<std::size_t> spread_places(std::size_t size, std::size_t wanted) {
  const std::size_t step = std::max<std::size_t>(1, size / wanted);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < size; i += step) places.push_back(i);
  return places;
}

struct Line {
  Vec3 direction;          ///< unit, of either sign
  double deviation = 0.0;  ///< of its points, root mean square
  double step = 0.0;       ///< mean distance between its points
};

/// The line that the first few of these lie on, nearest first; empty where they lie on none.
std::optional<Line> line_of(const std::vector<Vec3>& points, std::span<const Neighbor> nearest) {
  for (const std::size_t others : kOnLine) {
    if (nearest.size() <= others) break;
    const SymmetricEigen eigen = eigen_of(spread_of(points, nearest.first(others + 1)));
    const double beside = eigen.values[0] + eigen.values[1];
    if (beside > kMostBeside * eigen.values[2]) continue;
    const auto count = static_cast<double>(others);
    return Line{eigen.vectors[2], std::sqrt(beside / (count + 1.0)),
                2.0 * std::sqrt(nearest[others].squared_distance) / count};
  }
  return std::nullopt;
}

std::optional<Line> line_at(const SampledNeighbors::Place& place) {
  return line_of(place.site.points, place.nearest);
}

/// A point that is more than 30 degrees off a line, and how far it is from the line.
struct Beside {
  std::uint32_t point = 0;
  double distance = 0.0;
};

/// The nearest one of the neighbours of a point on the line, farther off than its noise.
std::optional<Beside> beside_line(const std::vector<Vec3>& points,
                                  std::span<const Neighbor> nearest, const Line& line) {
  constexpr double kOff = 0.5;  // sine
  constexpr double kDeviations = 4.0;
  for (const Neighbor& n : nearest.subspan(std::min(nearest.size(), kOnLine.front() + 1))) {
    const double along = dot(points[n.index] - points[nearest.front().index], line.direction);
    const double beside = std::sqrt(std::max(0.0, n.squared_distance - along * along));
    if (beside > kOff * std::sqrt(n.squared_distance) && beside > kDeviations * line.deviation)
      return Beside{n.index, beside};
  }
  return std::nullopt;
}

/// Looks for the lines beside those of places.
class LineSearch {
 public:
  explicit LineSearch(const SampledNeighbors& sample) : sample_(sample) {}

  /// Looks at more and more neighbours of a place on a line until one lies beside it.
  LinePlace look_across(std::size_t i, const Line& line) {
    constexpr std::size_t kFirst = 32, kMost = 512;
    const SampledNeighbors::Place place = sample_.at(i);
    const double step = line.step;
    const double border = distance_to_border(place.site.points[place.point], place.site.box);
    for (std::size_t count = kFirst; count <= kMost; count *= 4) {
      sample_.find_nearest(i, place.point, count, query_, found_);
      if (const auto beside = beside_line(place.site.points, found_, line)) {
        const bool is_sure = beside->distance <= border;
        if (beside->distance > kMostApart * step || !is_on_line(i, beside->point, line))
          return {i, 0.0, 0.0, is_sure};
        return {i, step, beside->distance, is_sure};
      }
      if (found_.size() < count || farthest() > kMostApart * step) break;
    }
    return {i, 0.0, 0.0, farthest() <= border};
  }

 private:
  double farthest() const { return std::sqrt(found_.back().squared_distance); }

  /// Whether a point lies on a line itself that runs in about the same direction, as a stray beside
  /// a thread does not.
  bool is_on_line(std::size_t i, std::uint32_t point, const Line& line) {
    constexpr double kSameWay = 0.5;  // cosine
    sample_.find_nearest(i, point, kOnLine.back() + 1, query_, others_);
    const auto other = line_of(sample_.at(i).site.points, others_);
    return other && std::abs(dot(other->direction, line.direction)) > kSameWay;
  }

  const SampledNeighbors& sample_;
  SiteSearch::Query query_;
  std::vector<Neighbor> found_, others_;
};

}  // namespace

std::vector<LinePlace> find_scan_lines(const SampledNeighbors& sample, const StopToken* stop) {
  const std::vector<std::size_t> looked_at = spread_places(sample.size(), kFirstLook);
  const auto on_line = std::ranges::count_if(
      looked_at, [&](std::size_t i) { return line_at(sample.at(i)).has_value(); });
  if (2 * static_cast<std::size_t>(on_line) < looked_at.size() || looked_at.empty()) return {};
  std::vector<LinePlace> places;
  for (const std::size_t i : spread_places(sample.size(), kMostPlaces)) places.push_back({i});
  for_each_whole((places.size() + kPlacesAtOnce - 1) / kPlacesAtOnce, [&](std::size_t block) {
    check_stop(stop);
    LineSearch search(sample);
    const std::size_t end = std::min(places.size(), (block + 1) * kPlacesAtOnce);
    for (std::size_t k = block * kPlacesAtOnce; k < end; ++k)
      if (const auto line = line_at(sample.at(places[k].place)))
        places[k] = search.look_across(places[k].place, *line);
  });
  const bool any_sure = std::ranges::any_of(places, &LinePlace::is_sure);
  if (any_sure) std::erase_if(places, [](const LinePlace& p) { return !p.is_sure; });
  const auto beside =
      std::ranges::count_if(places, [](const LinePlace& p) { return p.across > 0.0; });
  if (2 * static_cast<std::size_t>(beside) < places.size()) return {};
  return places;
}

std::size_t neighbors_across_lines(const std::vector<LinePlace>& places) {
  // As far on either side as the next line is away, a point's own line has two neighbours for each
  // point that fits between two lines.
  constexpr double kPerRatio = 2.5, kBeside = 4.0;
  std::vector<double> ratios;
  for (const LinePlace& place : places)
    if (place.along > 0.0) ratios.push_back(place.across / place.along);
  if (ratios.empty()) return 0;
  const auto widest = ratios.begin() + static_cast<std::ptrdiff_t>((ratios.size() - 1) * 95 / 100);
  std::ranges::nth_element(ratios, widest);
  return static_cast<std::size_t>(std::ceil(kPerRatio * *widest + kBeside));
}

}  // namespace orbweave
