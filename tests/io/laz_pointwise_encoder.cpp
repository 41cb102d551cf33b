#include <array>
#include <functional>

#include "io/clouds/laz/return_contexts.h"
#include "tests/io/laz_encoder.h"
#include "tests/io/laz_item_encoders.h"

namespace orbweave::test {
namespace {

using Record = const std::uint8_t*;

class Point10Encoder {
 public:
  explicit Point10Encoder(Record first) : last_(first, first + 20) { last_[12] = last_[13] = 0; }

  void encode(RangeEncoder& out, Record point) {
    const unsigned n = point[14] >> 3 & 7;
    const unsigned r = point[14] & 7;
    const unsigned m = laz::kReturnContexts16[n][r];
    encode_attributes(out, point, m);
    const auto step = [&](IntegerEncoder& steps, laz::StreamingMedian& median, std::size_t at,
                          unsigned context) {
      const std::uint32_t change =
          take<std::uint32_t>(point + at) - take<std::uint32_t>(&last_[at]);
      steps.encode(out, static_cast<std::uint32_t>(median.get()), change, context);
      median.add(static_cast<std::int32_t>(change));
    };
    const unsigned single = n == 1;
    step(x_, x_medians_[m], 0, single);
    step(y_, y_medians_[m], 4, single + (x_.width() < 20 ? x_.width() & ~1U : 20));
    const unsigned width = (x_.width() + y_.width()) / 2;
    std::uint32_t& height = heights_[n > r ? n - r : r - n];
    const auto z = take<std::uint32_t>(point + 8);
    z_.encode(out, height, z, single + (width < 18 ? width & ~1U : 18));
    height = z;
    last_.assign(point, point + 20);
  }

 private:
  void encode_attributes(RangeEncoder& out, Record point, unsigned m) {
    const auto intensity = take<std::uint16_t>(point + 12);
    const auto source = take<std::uint16_t>(point + 18);
    const auto last_source = take<std::uint16_t>(&last_[18]);
    unsigned changed = (point[14] != last_[14] ? 32U : 0U) | (point[15] != last_[15] ? 8U : 0U) |
                       (point[16] != last_[16] ? 4U : 0U) | (point[17] != last_[17] ? 2U : 0U) |
                       (source != last_source ? 1U : 0U);
    if (intensity != intensities_[m]) changed |= 16;
    out.symbol(changed_, changed);
    if (changed & 32) out.symbol(flags_[last_[14]], point[14]);
    if (changed & 16) {
      intensity_.encode(out, intensities_[m], intensity, m < 3 ? m : 3);
      intensities_[m] = intensity;
    }
    if (changed & 8) out.symbol(classes_[last_[15]], point[15]);
    if (changed & 4)
      out.symbol(angles_[point[14] >> 6 & 1], static_cast<std::uint8_t>(point[16] - last_[16]));
    if (changed & 2) out.symbol(users_[last_[17]], point[17]);
    if (changed & 1) source_.encode(out, last_source, source);
  }

  std::vector<std::uint8_t> last_;
  std::array<laz::StreamingMedian, 16> x_medians_, y_medians_;
  std::array<std::uint16_t, 16> intensities_{};
  std::array<std::uint32_t, 8> heights_{};
  SlowModel changed_{64};
  SlowModels flags_{256}, classes_{256}, angles_{256}, users_{256};
  IntegerEncoder intensity_{16}, source_{16}, x_{32}, y_{32}, z_{32};
};

using ItemEncoder = std::function<void(RangeEncoder&, Record)>;

ItemEncoder colour_encoder(Record first) {
  const auto colour = [](Record at) {
    return std::array{take<std::uint16_t>(at), take<std::uint16_t>(at + 2),
                      take<std::uint16_t>(at + 4)};
  };
  return [colour, last = colour(first), encoder = ColourEncoder()](
             RangeEncoder& out, Record at) mutable { encoder.encode(out, last, colour(at)); };
}

ItemEncoder wave_encoder(Record first) {
  const auto packet = [](Record at) {
    WavePacketEncoder::Packet bytes;
    std::copy_n(at, bytes.size(), bytes.begin());
    return bytes;
  };
  return [packet, last = packet(first), encoder = WavePacketEncoder()](
             RangeEncoder& out, Record at) mutable { encoder.encode(out, last, packet(at)); };
}

ItemEncoder byte_encoder(Record first, std::size_t bytes) {
  return [last = std::vector(first, first + bytes), models = SlowModels(256)](RangeEncoder& out,
                                                                              Record at) mutable {
    for (unsigned i = 0; i < last.size(); ++i)
      out.symbol(models[i], static_cast<std::uint8_t>(at[i] - last[i]));
    last.assign(at, at + last.size());
  };
}

}  // namespace

std::vector<std::uint8_t> encode_pointwise_chunk(const LazOptions& options,
                                                 std::span<const std::uint8_t> records) {
  const std::size_t size = record_bytes(options);
  const unsigned format = options.point_format;
  Record at = records.data();
  std::vector<std::pair<std::size_t, ItemEncoder>> items;
  const auto add = [&](std::size_t bytes, ItemEncoder encoder) {
    items.emplace_back(bytes, std::move(encoder));
    at += bytes;
  };
  add(20, [encoder = Point10Encoder(at)](RangeEncoder& out, Record point) mutable {
    encoder.encode(out, point);
  });
  if (format == 1 || format >= 3) {
    GpsTimeEncoder times(true);
    times.start(take<std::uint64_t>(at));
    add(8, [times](RangeEncoder& out, Record time) mutable {
      times.encode(out, take<std::uint64_t>(time));
    });
  }
  if (format == 2 || format == 3 || format == 5) add(6, colour_encoder(at));
  if (format >= 4) add(29, wave_encoder(at));
  if (options.extra_bytes > 0) add(options.extra_bytes, byte_encoder(at, options.extra_bytes));

  RangeEncoder out;
  for (std::size_t begin = size; begin < records.size(); begin += size) {
    at = &records[begin];
    for (auto& [bytes, encode] : items) {
      encode(out, at);
      at += bytes;
    }
  }
  std::vector<std::uint8_t> chunk(records.begin(), records.begin() + static_cast<long>(size));
  const std::vector<std::uint8_t> coded = out.finish();
  chunk.insert(chunk.end(), coded.begin(), coded.end());
  return chunk;
}

}  // namespace orbweave::test
