// Any bytes as PTX scans. The first byte chooses whether the source may look ahead.
#include "io/clouds/ptx_source.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = orbweave::fuzz::bytes_of(data + 1, size - 1);
  try {
    auto reader = orbweave::fuzz::reader_of(bytes);
    orbweave::looks_like_ptx(reader);
    std::function<orbweave::ByteReader()> again;
    if (data[0] % 2 != 0) again = [&] { return orbweave::fuzz::reader_of(bytes); };
    const auto source = orbweave::open_ptx_source(std::move(reader), again);
    orbweave::fuzz::drain(*source, 1 + size % 7);
    source->left_out();
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
