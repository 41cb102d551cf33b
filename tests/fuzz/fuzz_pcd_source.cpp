// Any bytes as a PCD cloud.
#include "io/clouds/pcd_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = orbweave::fuzz::bytes_of(data, size);
  try {
    auto reader = orbweave::fuzz::reader_of(bytes);
    orbweave::looks_like_pcd(reader);
    const auto source = orbweave::open_pcd_source(std::move(reader));
    orbweave::fuzz::drain(*source, 1 + size % 7);
    source->scanner();
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
