// Any bytes as the text of a coordinate system.
#include <cmath>
#include <string>

#include "io/points/coordinate_system.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto known = orbweave::known_coordinate_system(text);
  if (known && known->meters_per_unit && !(known->meters_per_unit->x > 0.0)) __builtin_trap();
  if (known && orbweave::systems_differ(text, known->wkt) == orbweave::SystemsDiffer::kUnknown &&
      !known->wkt.empty())
    __builtin_trap();
  orbweave::objection_to_coordinates(text, {{0, 0, 0}, {1000, 1000, 10}});
  return 0;
}
