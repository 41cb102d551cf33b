// Any bytes as a LAS file: either points or an Error, nothing else.
#include "io/clouds/las/las_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using orbweave::fuzz::bytes_of;
  try {
    const auto source =
        orbweave::open_las_source(orbweave::memory_random_access(bytes_of(data, size), "input"));
    if (source->coordinate_system().size() > size)
      throw std::logic_error("a coordinate system longer than the file");
    orbweave::fuzz::drain(*source, 1 + size % 7);
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
