#include "io/clouds/laz/point14.h"

#include <array>

#include "io/clouds/laz/adaptive_model.h"
#include "io/clouds/laz/attribute_decoders.h"
#include "io/clouds/laz/integer_decoder.h"
#include "io/clouds/laz/return_contexts.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

constexpr std::size_t kChannels = 4;

enum LayerIndex : std::size_t {
  kPlaceLayer,  ///< scanner channel, returns, x and y
  kHeightLayer,
  kClassLayer,
  kFlagLayer,
  kIntensityLayer,
  kAngleLayer,
  kUserLayer,
  kSourceLayer,
  kTimeLayer,
  kLayers
};

// Bits of the symbol that says what changed; the lower two tell how the return number did.
enum Change : unsigned {
  kReturnNumber = 3,
  kReturns = 4,
  kAngle = 8,
  kTime = 16,
  kSource = 32,
  kChannel = 64
};

struct Fields {
  std::uint32_t x = 0, y = 0, z = 0;
  std::uint16_t intensity = 0;
  unsigned return_number = 0, returns = 0;
  unsigned channel = 0;
  unsigned flags = 0;  ///< edge of flight line, scan direction, four flags of the class
  std::uint8_t point_class = 0, user = 0;
  std::uint16_t angle = 0, source = 0;
  std::uint64_t time = 0;

  void read(const std::byte* from);
  void write(std::byte* out) const;
  /// 1 for a first return, 2 for a last one, 3 for a single one, 0 for others.
  unsigned return_kind() const {
    return (return_number == 1 ? 1U : 0U) + (return_number >= returns ? 2U : 0U);
  }
};

void Fields::read(const std::byte* from) {
  x = load_little<std::uint32_t>(from);
  y = load_little<std::uint32_t>(from + 4);
  z = load_little<std::uint32_t>(from + 8);
  intensity = load_little<std::uint16_t>(from + 12);
  const unsigned return_bits = load_little<std::uint8_t>(from + 14);
  return_number = return_bits & 15U;
  returns = return_bits >> 4;
  const unsigned flag_bits = load_little<std::uint8_t>(from + 15);
  channel = flag_bits >> 4 & 3U;
  flags = (flag_bits & 15U) | (flag_bits >> 2 & 48U);
  point_class = load_little<std::uint8_t>(from + 16);
  user = load_little<std::uint8_t>(from + 17);
  angle = load_little<std::uint16_t>(from + 18);
  source = load_little<std::uint16_t>(from + 20);
  time = load_little<std::uint64_t>(from + 22);
}

void Fields::write(std::byte* out) const {
  store_little(out, x);
  store_little(out + 4, y);
  store_little(out + 8, z);
  store_little(out + 12, intensity);
  store_little(out + 14, static_cast<std::uint8_t>(return_number | returns << 4));
  store_little(out + 15,
               static_cast<std::uint8_t>((flags & 15U) | channel << 4 | (flags & 48U) << 2));
  store_little(out + 16, point_class);
  store_little(out + 17, user);
  store_little(out + 18, angle);
  store_little(out + 20, source);
  store_little(out + 22, time);
}

/// Statistics and last point of one scanner channel.
struct Channel {
  void start(const Fields& first);
  unsigned changed_context() const { return last.return_kind() + (time_changed ? 4U : 0U); }

  bool used = false;
  Fields last;
  bool time_changed = false;  ///< by the last point

  // Two contexts for each of the six of the returns: has the time changed?
  std::array<StreamingMedian, 12> x_steps, y_steps;
  std::array<std::uint32_t, 8> heights{};
  std::array<std::uint16_t, 8> intensities{};

  std::array<AdaptiveModel<128>, 8> changed;
  AdaptiveModel<3> channel_step;
  ModelBank<16> returns{16}, return_number{16};
  AdaptiveModel<13> return_number_step;
  IntegerDecoder<32, 2> x_differences;
  IntegerDecoder<32, 22> y_differences;
  IntegerDecoder<32, 20> z_differences;
  ModelBank<256> classes{64};
  ModelBank<64> flags{64};
  ModelBank<256> users{64};
  IntegerDecoder<16, 4> intensity_differences;
  IntegerDecoder<16, 2> angle_differences;
  IntegerDecoder<16, 1> source_differences;
  GpsTimeDecoder times{false};
};

void Channel::start(const Fields& first) {
  used = true;
  last = first;
  time_changed = false;
  x_steps = y_steps = {};
  heights.fill(first.z);
  intensities.fill(first.intensity);
  for (auto& model : changed) model.reset();
  channel_step.reset();
  returns.reset();
  return_number.reset();
  return_number_step.reset();
  x_differences.reset();
  y_differences.reset();
  z_differences.reset();
  classes.reset();
  flags.reset();
  users.reset();
  intensity_differences.reset();
  angle_differences.reset();
  source_differences.reset();
  times.reset(first.time);
}

class Point14 final : public LayeredItem {
 public:
  std::size_t layers() const override { return kLayers; }
  void start(const std::byte* first, std::span<Layer> layers, unsigned& channel) override;
  void decode(std::byte* out, unsigned& channel) override;

 private:
  Channel& begin(unsigned channel, const Fields& first);
  Channel& change_channel(Channel& from);
  void decode_returns(Channel& channel, unsigned changed);
  void decode_place(Channel& channel, bool time_changes);
  void decode_attributes(Channel& channel, unsigned changed);
  RangeDecoder& in(LayerIndex layer) { return layers_[layer].in; }
  bool has(LayerIndex layer) const { return layers_[layer].present; }

  std::array<std::unique_ptr<Channel>, kChannels> channels_;
  unsigned current_ = 0;
  std::span<Layer> layers_;
};

void Point14::start(const std::byte* first, std::span<Layer> layers, unsigned& channel) {
  layers_ = layers;
  for (auto& state : channels_)
    if (state) state->used = false;
  Fields fields;
  fields.read(first);
  current_ = channel = fields.channel;
  begin(current_, fields);
}

Channel& Point14::begin(unsigned channel, const Fields& first) {
  if (!channels_[channel]) channels_[channel] = std::make_unique<Channel>();
  channels_[channel]->start(first);
  channels_[channel]->last.channel = channel;
  return *channels_[channel];
}

void Point14::decode(std::byte* out, unsigned& channel) {
  Channel* state = channels_[current_].get();
  const unsigned changed = in(kPlaceLayer).symbol(state->changed[state->changed_context()]);
  if (changed & kChannel) state = &change_channel(*state);
  channel = current_;
  const bool time_changes = changed & kTime;
  decode_returns(*state, changed);
  decode_place(*state, time_changes);
  decode_attributes(*state, changed);
  state->time_changed = time_changes;
  state->last.write(out);
}

Channel& Point14::change_channel(Channel& from) {
  current_ = (current_ + in(kPlaceLayer).symbol(from.channel_step) + 1) % kChannels;
  if (channels_[current_] && channels_[current_]->used) return *channels_[current_];
  return begin(current_, from.last);
}

void Point14::decode_returns(Channel& channel, unsigned changed) {
  Fields& last = channel.last;
  const unsigned before = last.return_number;
  if (changed & kReturns) last.returns = in(kPlaceLayer).symbol(channel.returns[last.returns]);
  switch (changed & kReturnNumber) {
    case 0:
      return;
    case 1:
      last.return_number = (before + 1) % 16;
      return;
    case 2:
      last.return_number = (before + 15) % 16;
      return;
    default:
      last.return_number =
          changed & kTime ? in(kPlaceLayer).symbol(channel.return_number[before])
                          : (before + in(kPlaceLayer).symbol(channel.return_number_step) + 2) % 16;
  }
}

void Point14::decode_place(Channel& channel, bool time_changes) {
  Fields& last = channel.last;
  const std::size_t context =
      2U * kReturnContexts6[last.returns][last.return_number] + (time_changes ? 1U : 0U);
  const bool single = last.returns == 1;
  const auto step = [&](auto& differences, StreamingMedian& median, unsigned width) {
    const std::uint32_t change =
        differences.decode(in(kPlaceLayer), static_cast<std::uint32_t>(median.get()), width);
    median.add(static_cast<std::int32_t>(change));
    return change;
  };
  auto& x = channel.x_differences;
  auto& y = channel.y_differences;
  last.x += step(x, channel.x_steps[context], single ? 1 : 0);
  last.y += step(y, channel.y_steps[context], width_context(x.width(), 20, single));
  if (!has(kHeightLayer)) return;
  const unsigned width = (x.width() + y.width()) / 2;
  std::uint32_t& height = channel.heights[return_level(last.returns, last.return_number)];
  height = channel.z_differences.decode(in(kHeightLayer), height, width_context(width, 18, single));
  last.z = height;
}

void Point14::decode_attributes(Channel& channel, unsigned changed) {
  Fields& last = channel.last;
  const unsigned kind = last.return_kind();
  const bool time_changes = changed & kTime;
  if (has(kClassLayer)) {
    const std::size_t context = (last.point_class & 31U) * 2 + (kind == 3 ? 1U : 0U);
    last.point_class = static_cast<std::uint8_t>(in(kClassLayer).symbol(channel.classes[context]));
  }
  if (has(kFlagLayer)) last.flags = in(kFlagLayer).symbol(channel.flags[last.flags]);
  if (has(kIntensityLayer)) {
    std::uint16_t& intensity = channel.intensities[kind * 2 + (time_changes ? 1U : 0U)];
    intensity = static_cast<std::uint16_t>(
        channel.intensity_differences.decode(in(kIntensityLayer), intensity, kind));
    last.intensity = intensity;
  }
  if (has(kAngleLayer) && changed & kAngle)
    last.angle = static_cast<std::uint16_t>(
        channel.angle_differences.decode(in(kAngleLayer), last.angle, time_changes ? 1 : 0));
  if (has(kUserLayer))
    last.user = static_cast<std::uint8_t>(in(kUserLayer).symbol(channel.users[last.user / 4U]));
  if (has(kSourceLayer) && changed & kSource)
    last.source = static_cast<std::uint16_t>(
        channel.source_differences.decode(in(kSourceLayer), last.source));
  if (has(kTimeLayer) && changed & kTime) last.time = channel.times.decode(in(kTimeLayer));
}

}  // namespace

std::unique_ptr<LayeredItem> make_point14() { return std::make_unique<Point14>(); }

}  // namespace orbweave::laz
