#include "io/clouds/laz/layered_items.h"

#include <array>
#include <cstring>
#include <vector>

#include "io/clouds/laz/adaptive_model.h"
#include "io/clouds/laz/attribute_decoders.h"
#include "io/clouds/laz/point14.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

constexpr std::size_t kChannels = 4;

/// Statistics and last value of each scanner channel; a channel begins with the last value of the
/// one before it.
template <class State>
class PerChannel {
 public:
  explicit PerChannel(const ItemLayout& item)
      : bytes_(item.bytes), keeps_last_(item.version == 3) {}

  /// The state of the chunk's first channel, to be given its last value.
  State& start(unsigned channel) {
    used_ = {};
    current_ = channel;
    return begin(channel);
  }

  /// For one point: its statistics, and the value it is predicted from and becomes.
  struct Turn {
    State& models;
    State& last;
  };
  Turn turn(unsigned channel) {
    State& before = *states_[current_];
    if (channel == current_) return {before, before};
    current_ = channel;
    if (!used_[channel]) {
      State& fresh = begin(channel);
      fresh.last = before.last;
      return {fresh, fresh};
    }
    // Version 3 takes the value of the channel left behind for the first point after a change to
    // a channel that had been used before; version 4 exists because that was not intended.
    State& now = *states_[channel];
    return {now, keeps_last_ ? before : now};
  }

 private:
  State& begin(unsigned channel) {
    if (!states_[channel]) states_[channel] = std::make_unique<State>(bytes_);
    states_[channel]->reset();
    used_[channel] = true;
    return *states_[channel];
  }

  std::size_t bytes_;
  bool keeps_last_;
  std::array<std::unique_ptr<State>, kChannels> states_;
  std::array<bool, kChannels> used_{};
  unsigned current_ = 0;
};

struct ColourState {
  explicit ColourState(std::size_t) {}
  void reset() {
    colours.reset();
    infrared.reset();
  }
  struct {
    ColourDecoder::Colour colour{};
    std::uint16_t infrared = 0;
  } last;
  ColourDecoder colours;
  InfraredDecoder infrared;
};

/// RGB14 and RGBNIR14.
class Colours14 final : public LayeredItem {
 public:
  explicit Colours14(const ItemLayout& item)
      : has_infrared_(item.type == ItemType::kRgbNir14), channels_(item) {}

  std::size_t layers() const override { return has_infrared_ ? 2 : 1; }

  void start(const std::byte* first, std::span<Layer> layers, unsigned& channel) override {
    layers_ = layers;
    auto& last = channels_.start(channel).last;
    for (std::size_t i = 0; i < 3; ++i) last.colour[i] = load_little<std::uint16_t>(first + 2 * i);
    if (has_infrared_) last.infrared = load_little<std::uint16_t>(first + 6);
  }

  void decode(std::byte* out, unsigned& channel) override {
    const auto turn = channels_.turn(channel);
    auto& last = turn.last.last;
    if (layers_[0].present) turn.models.colours.decode(layers_[0].in, last.colour);
    for (std::size_t i = 0; i < 3; ++i) store_little(out + 2 * i, last.colour[i]);
    if (!has_infrared_) return;
    if (layers_[1].present) turn.models.infrared.decode(layers_[1].in, last.infrared);
    store_little(out + 6, last.infrared);
  }

 private:
  bool has_infrared_;
  std::span<Layer> layers_;
  PerChannel<ColourState> channels_;
};

struct WavePacketState {
  explicit WavePacketState(std::size_t) {}
  void reset() { packets.reset(); }
  WavePacketDecoder::Packet last{};
  WavePacketDecoder packets;
};

class WavePacket14 final : public LayeredItem {
 public:
  explicit WavePacket14(const ItemLayout& item) : channels_(item) {}

  std::size_t layers() const override { return 1; }

  void start(const std::byte* first, std::span<Layer> layers, unsigned& channel) override {
    layers_ = layers;
    auto& last = channels_.start(channel).last;
    std::memcpy(last.data(), first, last.size());
  }

  void decode(std::byte* out, unsigned& channel) override {
    const auto turn = channels_.turn(channel);
    auto& last = turn.last.last;
    if (layers_[0].present) turn.models.packets.decode(layers_[0].in, last);
    std::memcpy(out, last.data(), last.size());
  }

 private:
  std::span<Layer> layers_;
  PerChannel<WavePacketState> channels_;
};

struct ExtraBytesState {
  explicit ExtraBytesState(std::size_t bytes) : last(bytes), models(bytes) {}
  void reset() { models.reset(); }
  std::vector<std::uint8_t> last;
  ModelBank<256> models;
};

class ExtraBytes14 final : public LayeredItem {
 public:
  explicit ExtraBytes14(const ItemLayout& item) : bytes_(item.bytes), channels_(item) {}

  std::size_t layers() const override { return bytes_; }

  void start(const std::byte* first, std::span<Layer> layers, unsigned& channel) override {
    layers_ = layers;
    std::memcpy(channels_.start(channel).last.data(), first, bytes_);
  }

  void decode(std::byte* out, unsigned& channel) override {
    const auto turn = channels_.turn(channel);
    std::uint8_t* last = turn.last.last.data();
    for (std::size_t i = 0; i < bytes_; ++i)
      if (layers_[i].present)
        last[i] = static_cast<std::uint8_t>(last[i] + layers_[i].in.symbol(turn.models.models[i]));
    std::memcpy(out, last, bytes_);
  }

 private:
  std::size_t bytes_;
  std::span<Layer> layers_;
  PerChannel<ExtraBytesState> channels_;
};

}  // namespace

std::unique_ptr<LayeredItem> make_layered_item(const ItemLayout& item) {
  switch (item.type) {
    case ItemType::kPoint14:
      return make_point14();
    case ItemType::kRgb14:
    case ItemType::kRgbNir14:
      return std::make_unique<Colours14>(item);
    case ItemType::kWavePacket14:
      return std::make_unique<WavePacket14>(item);
    default:
      return std::make_unique<ExtraBytes14>(item);
  }
}

}  // namespace orbweave::laz
