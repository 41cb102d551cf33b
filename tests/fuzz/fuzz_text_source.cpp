// Any bytes as a text cloud. The first byte chooses the options.
#include "io/clouds/text_layout.h"
#include "io/clouds/text_source.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

orbweave::TextOptions options_from(std::uint8_t choice) {
  orbweave::TextOptions options;
  constexpr char kSeparators[] = {'\0', ',', '\t', ' '};
  options.separator = kSeparators[choice % 4];
  if ((choice & 8) != 0) options.columns = {"x", "-", "y", "z:float32", "label:uint16"};
  return options;
}

orbweave::TextKind kind_from(std::uint8_t choice) {
  using orbweave::TextKind;
  constexpr TextKind kOthers[] = {TextKind::kAny, TextKind::kNormals, TextKind::kColors};
  return (choice & 4) != 0 ? TextKind::kPts : kOthers[(choice >> 4) % 3];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::uint8_t choice = data[0];
  try {
    const auto bytes = orbweave::fuzz::bytes_of(data + 1, size - 1);
    const auto source = orbweave::open_text_source(orbweave::fuzz::reader_of(bytes),
                                                   options_from(choice), kind_from(choice));
    orbweave::fuzz::drain(*source, 1 + size % 7);
  } catch (const orbweave::Error&) {
    // Damage, said so.
  }
  return 0;
}
