#include "io/clouds/las/las_extra_bytes.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "io/text/little_endian.h"

namespace orbweave::las {
namespace {

// A descriptor and the places of its fields, in bytes.
constexpr std::size_t kDescriptorBytes = 192;
constexpr std::size_t kDataType = 2;
constexpr std::size_t kOptions = 3;
constexpr std::size_t kName = 4;
constexpr std::size_t kNameBytes = 32;
constexpr std::size_t kScale = 112;
constexpr std::size_t kOffset = 136;

constexpr unsigned kScaleBit = 1u << 3;
constexpr unsigned kOffsetBit = 1u << 4;

/// By data type, from 1 on; 11 to 20 are pairs of these, 21 to 30 triples.
constexpr std::array<ScalarType, 10> kTypes = {
    ScalarType::kUint8,   ScalarType::kInt8,   ScalarType::kUint16, ScalarType::kInt16,
    ScalarType::kUint32,  ScalarType::kInt32,  ScalarType::kUint64, ScalarType::kInt64,
    ScalarType::kFloat32, ScalarType::kFloat64};

struct Descriptor {
  const std::byte* bytes;

  unsigned type() const { return load_little<std::uint8_t>(bytes + kDataType); }
  unsigned options() const { return load_little<std::uint8_t>(bytes + kOptions); }
  bool is_known() const { return type() <= 3 * kTypes.size(); }
  bool is_undocumented() const { return type() == 0; }
  ScalarType scalar() const { return kTypes[(type() - 1) % kTypes.size()]; }
  std::size_t components() const { return 1 + (type() - 1) / kTypes.size(); }
  /// All of it; for undocumented bytes the options are their number.
  std::size_t size() const {
    return is_undocumented() ? options() : components() * size_of(scalar());
  }
  std::string name() const {
    const std::string_view padded(reinterpret_cast<const char*>(bytes + kName), kNameBytes);
    return std::string(padded.substr(0, padded.find('\0')));
  }
};

StoredValue component_of(const Descriptor& descriptor, std::size_t component, std::size_t offset) {
  StoredValue value{.name = descriptor.name(), .type = descriptor.scalar(), .offset = offset};
  if (descriptor.components() > 1) value.name += "_" + std::to_string(component);
  const std::size_t skip = component * sizeof(double);
  if ((descriptor.options() & kScaleBit) != 0)
    value.scale = load_little<double>(descriptor.bytes + kScale + skip);
  if ((descriptor.options() & kOffsetBit) != 0)
    value.shift = load_little<double>(descriptor.bytes + kOffset + skip);
  // Numbers that would leave nothing of the value are taken for unset.
  const bool is_sound =
      std::isfinite(value.scale) && value.scale != 0.0 && std::isfinite(value.shift);
  value.is_scaled = is_sound && (descriptor.options() & (kScaleBit | kOffsetBit)) != 0;
  return value;
}

}  // namespace

std::vector<StoredValue> extra_values(std::span<const std::byte> payload, std::size_t first,
                                      std::size_t record_bytes) {
  std::vector<StoredValue> values;
  for (; payload.size() >= kDescriptorBytes; payload = payload.subspan(kDescriptorBytes)) {
    const Descriptor descriptor{payload.data()};
    if (!descriptor.is_known() || descriptor.size() > record_bytes - first) break;
    if (!descriptor.is_undocumented())
      for (std::size_t c = 0; c < descriptor.components(); ++c)
        values.push_back(component_of(descriptor, c, first + c * size_of(descriptor.scalar())));
    first += descriptor.size();
  }
  return values;
}

}  // namespace orbweave::las
