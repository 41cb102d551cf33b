#include "io/clouds/laz/pointwise_items.h"

#include <array>
#include <cstring>
#include <vector>

#include "io/clouds/laz/adaptive_model.h"
#include "io/clouds/laz/attribute_decoders.h"
#include "io/clouds/laz/integer_decoder.h"
#include "io/clouds/laz/return_contexts.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

/// x, y, z (int32), intensity, flags, classification, scan angle, user data, point source.
class Point10 final : public PointwiseItem {
 public:
  void start(const std::byte* first) override;
  void decode(RangeDecoder& in, std::byte* out) override;

 private:
  // Bits of the symbol that says what changed.
  enum Change : unsigned {
    kSource = 1,
    kUser = 2,
    kAngle = 4,
    kClass = 8,
    kIntensity = 16,
    kFlags = 32
  };

  void decode_attributes(RangeDecoder& in, unsigned changed);
  void decode_place(RangeDecoder& in);
  unsigned return_context() const { return kReturnContexts16[returns()][return_number()]; }
  unsigned return_number() const { return flags_ & 7U; }
  unsigned returns() const { return flags_ >> 3 & 7U; }
  unsigned scan_direction() const { return flags_ >> 6 & 1U; }
  void write(std::byte* out) const;

  std::uint32_t x_ = 0, y_ = 0;
  std::uint32_t z_ = 0;
  std::uint16_t intensity_ = 0;
  std::uint8_t flags_ = 0, class_ = 0, angle_ = 0, user_ = 0;
  std::uint16_t source_ = 0;

  std::array<StreamingMedian, 16> x_steps_, y_steps_;
  std::array<std::uint16_t, 16> intensities_{};
  std::array<std::uint32_t, 8> heights_{};

  AdaptiveModel<64> changed_;
  ModelBank<256> flag_models_{256}, class_models_{256}, user_models_{256};
  std::array<AdaptiveModel<256>, 2> angle_models_;
  IntegerDecoder<16, 4> intensity_differences_;
  IntegerDecoder<16, 1> source_differences_;
  IntegerDecoder<32, 2> x_differences_;
  IntegerDecoder<32, 22> y_differences_;
  IntegerDecoder<32, 20> z_differences_;
};

void Point10::start(const std::byte* first) {
  x_ = load_little<std::uint32_t>(first);
  y_ = load_little<std::uint32_t>(first + 4);
  z_ = load_little<std::uint32_t>(first + 8);
  intensity_ = 0;  // as the format has it, whatever the first point's is
  flags_ = load_little<std::uint8_t>(first + 14);
  class_ = load_little<std::uint8_t>(first + 15);
  angle_ = load_little<std::uint8_t>(first + 16);
  user_ = load_little<std::uint8_t>(first + 17);
  source_ = load_little<std::uint16_t>(first + 18);
  x_steps_ = y_steps_ = {};
  intensities_ = {};
  heights_ = {};
  changed_.reset();
  flag_models_.reset();
  class_models_.reset();
  user_models_.reset();
  for (auto& model : angle_models_) model.reset();
  intensity_differences_.reset();
  source_differences_.reset();
  x_differences_.reset();
  y_differences_.reset();
  z_differences_.reset();
}

void Point10::decode(RangeDecoder& in, std::byte* out) {
  if (const unsigned changed = in.symbol(changed_)) decode_attributes(in, changed);
  decode_place(in);
  write(out);
}

void Point10::decode_attributes(RangeDecoder& in, unsigned changed) {
  const auto byte = [&](AdaptiveModel<256>& model) {
    return static_cast<std::uint8_t>(in.symbol(model));
  };
  if (changed & kFlags) flags_ = byte(flag_models_[flags_]);
  const unsigned context = return_context();
  if (changed & kIntensity)
    intensities_[context] = static_cast<std::uint16_t>(
        intensity_differences_.decode(in, intensities_[context], std::min(context, 3U)));
  intensity_ = intensities_[context];
  if (changed & kClass) class_ = byte(class_models_[class_]);
  if (changed & kAngle)
    angle_ = static_cast<std::uint8_t>(angle_ + byte(angle_models_[scan_direction()]));
  if (changed & kUser) user_ = byte(user_models_[user_]);
  if (changed & kSource)
    source_ = static_cast<std::uint16_t>(source_differences_.decode(in, source_));
}

void Point10::decode_place(RangeDecoder& in) {
  const unsigned context = return_context();
  const bool single = returns() == 1;
  const auto step = [&](auto& differences, StreamingMedian& median, unsigned width) {
    const std::uint32_t change =
        differences.decode(in, static_cast<std::uint32_t>(median.get()), width);
    median.add(static_cast<std::int32_t>(change));
    return change;
  };
  x_ += step(x_differences_, x_steps_[context], single ? 1 : 0);
  y_ += step(y_differences_, y_steps_[context], width_context(x_differences_.width(), 20, single));
  const unsigned width = (x_differences_.width() + y_differences_.width()) / 2;
  std::uint32_t& height = heights_[return_level(returns(), return_number())];
  height = z_differences_.decode(in, height, width_context(width, 18, single));
  z_ = height;
}

void Point10::write(std::byte* out) const {
  store_little(out, x_);
  store_little(out + 4, y_);
  store_little(out + 8, z_);
  store_little(out + 12, intensity_);
  store_little(out + 14, flags_);
  store_little(out + 15, class_);
  store_little(out + 16, angle_);
  store_little(out + 17, user_);
  store_little(out + 18, source_);
}

class GpsTime11 final : public PointwiseItem {
 public:
  void start(const std::byte* first) override { times_.reset(load_little<std::uint64_t>(first)); }
  void decode(RangeDecoder& in, std::byte* out) override { store_little(out, times_.decode(in)); }

 private:
  GpsTimeDecoder times_{true};
};

class Rgb12 final : public PointwiseItem {
 public:
  void start(const std::byte* first) override {
    for (std::size_t i = 0; i < 3; ++i) last_[i] = load_little<std::uint16_t>(first + 2 * i);
    colours_.reset();
  }
  void decode(RangeDecoder& in, std::byte* out) override {
    colours_.decode(in, last_);
    for (std::size_t i = 0; i < 3; ++i) store_little(out + 2 * i, last_[i]);
  }

 private:
  ColourDecoder::Colour last_{};
  ColourDecoder colours_;
};

class WavePacket13 final : public PointwiseItem {
 public:
  void start(const std::byte* first) override {
    std::memcpy(last_.data(), first, last_.size());
    packets_.reset();
  }
  void decode(RangeDecoder& in, std::byte* out) override {
    packets_.decode(in, last_);
    std::memcpy(out, last_.data(), last_.size());
  }

 private:
  WavePacketDecoder::Packet last_{};
  WavePacketDecoder packets_;
};

class ExtraBytes final : public PointwiseItem {
 public:
  explicit ExtraBytes(std::size_t bytes) : last_(bytes), models_(bytes) {}
  void start(const std::byte* first) override {
    std::memcpy(last_.data(), first, last_.size());
    models_.reset();
  }
  void decode(RangeDecoder& in, std::byte* out) override {
    for (std::size_t i = 0; i < last_.size(); ++i)
      last_[i] = static_cast<std::uint8_t>(last_[i] + in.symbol(models_[i]));
    std::memcpy(out, last_.data(), last_.size());
  }

 private:
  std::vector<std::uint8_t> last_;
  ModelBank<256> models_;
};

}  // namespace

std::unique_ptr<PointwiseItem> make_pointwise_item(const ItemLayout& item) {
  switch (item.type) {
    case ItemType::kPoint10:
      return std::make_unique<Point10>();
    case ItemType::kGpsTime11:
      return std::make_unique<GpsTime11>();
    case ItemType::kRgb12:
      return std::make_unique<Rgb12>();
    case ItemType::kWavePacket13:
      return std::make_unique<WavePacket13>();
    default:
      return std::make_unique<ExtraBytes>(item.bytes);
  }
}

}  // namespace orbweave::laz
