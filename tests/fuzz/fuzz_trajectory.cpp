// Any bytes as the text of a trajectory. Each of its ends is where the path says it is.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "io/clouds/trajectory_file.h"
#include "io/error.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const orbweave::Trajectory path = orbweave::read_trajectory_text(
        orbweave::fuzz::reader_of(orbweave::fuzz::bytes_of(data, size)));
    require(path.first_time() < path.last_time());
    for (const double time : {path.first_time(), path.last_time()}) {
      const auto place = path.at(time);
      require(place && path.bounds().contains(*place));
    }
    const double middle = 0.5 * path.first_time() + 0.5 * path.last_time();
    for (const double time : {middle, 0.0, 3.1e8, 1.4e9, 259'200.0, std::nextafter(middle, 0.0)})
      path.at(time);
  } catch (const orbweave::Error& error) {
    require(error.kind() == orbweave::ErrorKind::kBadInput);
  }
  return 0;
}
