#include "engine/validation/usable_scale.h"

#include <algorithm>
#include <cmath>

#include "io/error.h"
#include "io/text/quantity.h"
#include "partition/point_filter.h"

namespace orbweave {
namespace {

constexpr double kLeastExtent = 1e-75;

bool is_too_small(const Box& bounds) {
  return !bounds.empty() && bounds.largest_extent() > 0.0 && bounds.largest_extent() < kLeastExtent;
}

double largest_coordinate(const Box& bounds) {
  double largest = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::abs(bounds.min[axis]), std::abs(bounds.max[axis])});
  return largest;
}

}  // namespace

void require_usable_scale(const std::string& file, const std::string& what, const Box& bounds) {
  if (bounds.empty()) return;
  const auto refuse = [&](const char* size, const std::string& found, const char* unit) {
    throw_bad_input("the " + what + " is too " + size + " to be computed with",
                    {.file = file,
                     .place = {},
                     .found = found,
                     .expected = "an extent from 1e-75 to 1e75",
                     .advice = std::string("Scale the coordinates to a ") + unit + " unit."});
  };
  if (const double largest = largest_coordinate(bounds); largest > kLargestCoordinate)
    refuse("large", "a coordinate of " + format_number(largest), "larger");
  if (is_too_small(bounds))
    refuse("small", "an extent of " + format_number(bounds.largest_extent()), "smaller");
}

std::string objection_to_scale(const Box& bounds) {
  if (!is_too_small(bounds)) return {};
  return "an extent of " + format_number(bounds.largest_extent()) +
         " is too small to be computed with: the coordinates need a smaller unit";
}

}  // namespace orbweave
