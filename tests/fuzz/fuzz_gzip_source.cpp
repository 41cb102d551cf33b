// Any bytes as gzip data, and what comes out as a text cloud.
#include "io/clouds/text_source.h"
#include "io/streams/gzip_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using orbweave::fuzz::bytes_of;
  try {
    auto compressed = orbweave::memory_byte_source(bytes_of(data, size), "input");
    orbweave::ByteReader reader(orbweave::gunzip_byte_source(std::move(compressed)));
    const auto source = orbweave::open_text_source(std::move(reader), {}, orbweave::TextKind::kAny);
    orbweave::fuzz::drain(*source, 5);
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
