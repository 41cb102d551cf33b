#include "engine/holes/plane/plane_outline.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace orbweave {
namespace {

double squared_distance_to_edge(Vec3 x, Vec3 a, Vec3 b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length = dx * dx + dy * dy;
  const double along = length > 0.0 ? ((x.x - a.x) * dx + (x.y - a.y) * dy) / length : 0.0;
  const double t = std::clamp(along, 0.0, 1.0);
  const double ex = a.x + t * dx - x.x;
  const double ey = a.y + t * dy - x.y;
  return ex * ex + ey * ey;
}

}  // namespace

PlaneOutline::PlaneOutline(std::vector<Vec3> polygon, double reach)
    : polygon_(std::move(polygon)), reach_(reach), low_(polygon_[0]), high_(polygon_[0]) {
  for (const Vec3 p : polygon_) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y), 0.0};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y), 0.0};
  }
  const double n = static_cast<double>(polygon_.size());
  strip_height_ = std::max((high_.y - low_.y) / n, reach_);
  const std::size_t strips = strip_of(high_.y + reach_) + 1;
  first_.assign(strips + 1, 0);
  const auto for_each_strip = [this](const auto& visit) {
    for (std::uint32_t i = 0; i < polygon_.size(); ++i) {
      const double a = polygon_[i].y;
      const double b = polygon_[(i + 1) % polygon_.size()].y;
      const std::size_t last = strip_of(std::max(a, b) + reach_);
      for (std::size_t s = strip_of(std::min(a, b) - reach_); s <= last; ++s) visit(s, i);
    }
  };
  for_each_strip([this](std::size_t s, std::uint32_t) { ++first_[s + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  edges_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for_each_strip([&](std::size_t s, std::uint32_t i) { edges_[next[s]++] = i; });
}

std::size_t PlaneOutline::strip_of(double y) const {
  const double strip = std::floor((y - (low_.y - reach_)) / strip_height_);
  const double last = first_.empty() ? strip : static_cast<double>(first_.size() - 2);
  return static_cast<std::size_t>(std::clamp(strip, 0.0, std::max(last, 0.0)));
}

bool PlaneOutline::contains(Vec3 x) const {
  const std::size_t strip = strip_of(x.y);
  int winding = 0;
  for (std::uint32_t k = first_[strip]; k < first_[strip + 1]; ++k) {
    const Vec3 a = polygon_[edges_[k]];
    const Vec3 b = polygon_[(edges_[k] + 1) % polygon_.size()];
    if ((a.y <= x.y) == (b.y <= x.y)) continue;
    const double side = (b.x - a.x) * (x.y - a.y) - (b.y - a.y) * (x.x - a.x);
    if (b.y > a.y && side > 0.0) ++winding;
    if (b.y < a.y && side < 0.0) --winding;
  }
  return winding > 0;
}

double PlaneOutline::distance(Vec3 x) const {
  const std::size_t strip = strip_of(x.y);
  double least = reach_ * reach_;
  for (std::uint32_t k = first_[strip]; k < first_[strip + 1]; ++k) {
    const Vec3 a = polygon_[edges_[k]];
    const Vec3 b = polygon_[(edges_[k] + 1) % polygon_.size()];
    least = std::min(least, squared_distance_to_edge(x, a, b));
  }
  return std::sqrt(least);
}

}  // namespace orbweave
