// Any bytes as a PLY cloud: either points or an Error, nothing else.
#include "io/clouds/ply_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using orbweave::fuzz::bytes_of;
  try {
    const auto source = orbweave::open_ply_source(orbweave::fuzz::reader_of(bytes_of(data, size)));
    orbweave::fuzz::drain(*source, 1 + size % 7);
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
