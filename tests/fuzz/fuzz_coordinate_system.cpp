// Any bytes as the text of a coordinate system: as a scan has it, or "=" and a user's words.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "io/points/coordinate_system.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using orbweave::Vec3;

void require(bool holds) {
  if (!holds) std::abort();
}

void check_known(const std::string& text) {
  const auto known = orbweave::known_coordinate_system(text);
  if (!known) return;
  const Vec3 unit = known->meters_per_unit.value_or(Vec3{1, 1, 1});
  require(unit.x > 0.0 && unit.y > 0.0 && unit.z > 0.0);
  require(known->wkt.empty() ||
          orbweave::systems_differ(text, known->wkt) != orbweave::SystemsDiffer::kUnknown);
}

/// What a user's text is taken for is a system, and stays as it is where it is read again.
void check_words(const std::string& text) {
  const std::string system = orbweave::system_of_text(text);
  if (system.empty() || system == text) return;
  require(orbweave::system_of_text(system) == system);
  const bool is_code = system.starts_with("EPSG:");
  require(is_code || orbweave::known_coordinate_system(system).has_value());
}

void check_place(const std::string& text) {
  const auto matrix = orbweave::earth_from_local(text, {1000, 1000, 10});
  require(!matrix || std::ranges::all_of(*matrix, [](double x) { return std::isfinite(x); }));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (text.starts_with('=')) {
    check_words(text.substr(1));
    return 0;
  }
  check_known(text);
  check_place(text);
  orbweave::objection_to_coordinates(text, {{0, 0, 0}, {1000, 1000, 10}});
  return 0;
}
