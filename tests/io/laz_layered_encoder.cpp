#include <array>
#include <functional>
#include <map>

#include "io/clouds/laz/return_contexts.h"
#include "tests/io/laz_encoder.h"
#include "tests/io/laz_item_encoders.h"

namespace orbweave::test {
namespace {

using Record = const std::uint8_t*;

/// One attribute's stream, left out when nothing changed.
struct LayerOut {
  RangeEncoder out;
  bool changed = false;
};
using Layers = std::vector<LayerOut>;

struct Point {
  explicit Point(Record at)
      : x(take<std::uint32_t>(at)),
        y(take<std::uint32_t>(at + 4)),
        z(take<std::uint32_t>(at + 8)),
        intensity(take<std::uint16_t>(at + 12)),
        r(at[14] & 15),
        n(at[14] >> 4),
        channel(at[15] >> 4 & 3),
        flags((at[15] & 15U) | (at[15] >> 6) * 16U),
        point_class(at[16]),
        user(at[17]),
        angle(take<std::uint16_t>(at + 18)),
        source(take<std::uint16_t>(at + 20)),
        time(take<std::uint64_t>(at + 22)) {}
  unsigned kind() const { return (r == 1 ? 1U : 0U) + (r >= n ? 2U : 0U); }

  std::uint32_t x, y, z;
  std::uint16_t intensity;
  unsigned r, n, channel, flags;
  std::uint8_t point_class, user;
  std::uint16_t angle, source;
  std::uint64_t time;
};

struct ChannelState {
  explicit ChannelState(const Point& first) : last(first) {
    heights.fill(first.z);
    intensities.fill(first.intensity);
    times.start(first.time);
  }
  Point last;
  bool time_changed = false;
  std::array<laz::StreamingMedian, 12> x_medians, y_medians;
  std::array<std::uint32_t, 8> heights{};
  std::array<std::uint16_t, 8> intensities{};
  SlowModels changed{128}, channel_step{3}, returns{16}, return_number{16}, return_step{13};
  SlowModels classes{256}, flags{64}, users{256};
  IntegerEncoder x{32}, y{32}, z{32}, intensity{16}, angle{16}, source{16};
  GpsTimeEncoder times{false};
};

class Point14Encoder {
 public:
  explicit Point14Encoder(const Point& first) : current_(first.channel) {
    states_.emplace(current_, first);
  }

  void encode(LayerOut* layers, const Point& point) {
    ChannelState& before = states_.at(current_);
    const bool channel_changes = point.channel != current_;
    ChannelState& now = states_.try_emplace(point.channel, before.last).first->second;
    const bool time_changes = point.time != now.last.time;
    const unsigned turn = (point.r - now.last.r) & 15;
    const unsigned changed = (channel_changes ? 64U : 0U) |
                             (point.source != now.last.source ? 32U : 0U) |
                             (time_changes ? 16U : 0U) | (point.angle != now.last.angle ? 8U : 0U) |
                             (point.n != now.last.n ? 4U : 0U) |
                             (turn == 0    ? 0U
                              : turn == 1  ? 1U
                              : turn == 15 ? 2U
                                           : 3U);
    RangeEncoder& out = layers[0].out;
    out.symbol(before.changed[before.last.kind() + (before.time_changed ? 4 : 0)], changed);
    if (channel_changes) out.symbol(before.channel_step[0], (point.channel - current_ - 1) & 3);
    current_ = point.channel;
    layers[0].changed = true;
    if (changed & 4) out.symbol(now.returns[now.last.n], point.n);
    if ((changed & 3) == 3)
      time_changes ? out.symbol(now.return_number[now.last.r], point.r)
                   : out.symbol(now.return_step[0], turn - 2);
    encode_place(layers, now, point, time_changes);
    encode_attributes(layers, now, point, changed);
    now.last = point;
    now.time_changed = time_changes;
  }

 private:
  static void encode_place(LayerOut* layers, ChannelState& now, const Point& point,
                           bool time_changes) {
    const unsigned single = point.n == 1;
    const std::size_t m = laz::kReturnContexts6[point.n][point.r] * 2U + (time_changes ? 1 : 0);
    const auto step = [&](IntegerEncoder& steps, laz::StreamingMedian& median, std::uint32_t change,
                          unsigned context) {
      steps.encode(layers[0].out, static_cast<std::uint32_t>(median.get()), change, context);
      median.add(static_cast<std::int32_t>(change));
    };
    step(now.x, now.x_medians[m], point.x - now.last.x, single);
    step(now.y, now.y_medians[m], point.y - now.last.y,
         single + (now.x.width() < 20 ? now.x.width() & ~1U : 20));
    const unsigned width = (now.x.width() + now.y.width()) / 2;
    std::uint32_t& height = now.heights[laz::return_level(point.n, point.r)];
    now.z.encode(layers[1].out, height, point.z, single + (width < 18 ? width & ~1U : 18));
    layers[1].changed |= point.z != now.last.z;
    height = point.z;
  }

  static void encode_attributes(LayerOut* layers, ChannelState& now, const Point& point,
                                unsigned changed) {
    const Point& last = now.last;
    const unsigned kind = point.kind();
    const unsigned time_changes = changed & 16 ? 1 : 0;
    layers[2].out.symbol(now.classes[(last.point_class & 31U) * 2 + (kind == 3 ? 1 : 0)],
                         point.point_class);
    layers[2].changed |= point.point_class != last.point_class;
    layers[3].out.symbol(now.flags[last.flags], point.flags);
    layers[3].changed |= point.flags != last.flags;
    std::uint16_t& intensity = now.intensities[kind * 2 + time_changes];
    now.intensity.encode(layers[4].out, intensity, point.intensity, kind);
    layers[4].changed |= point.intensity != last.intensity;
    intensity = point.intensity;
    if (changed & 8) now.angle.encode(layers[5].out, last.angle, point.angle, time_changes);
    layers[5].changed |= (changed & 8) != 0;
    layers[6].out.symbol(now.users[last.user / 4U], point.user);
    layers[6].changed |= point.user != last.user;
    if (changed & 32) now.source.encode(layers[7].out, last.source, point.source);
    layers[7].changed |= (changed & 32) != 0;
    if (time_changes != 0) now.times.encode(layers[8].out, point.time);
    layers[8].changed |= time_changes != 0;
  }

  std::map<unsigned, ChannelState> states_;
  unsigned current_;
};

/// State by channel of every other item: encode(layers, models, last, value).
template <class Models, class Value>
class OtherItem {
 public:
  using Encode = std::function<void(LayerOut*, Models&, Value& last, const Value& value)>;
  OtherItem(unsigned version, unsigned channel, const Value& first, Encode encode)
      : version_(version), current_(channel), encode_(std::move(encode)) {
    states_[channel].last = first;
  }

  void operator()(LayerOut* layers, unsigned channel, const Value& value) {
    State& before = states_[current_];
    const bool fresh = !states_.contains(channel);
    State& now = states_[channel];
    if (fresh) now.last = before.last;
    // What version 3 does on a return to a channel (io/clouds/laz/layered_items.cpp).
    Value& last = version_ == 3 && !fresh ? before.last : now.last;
    current_ = channel;
    encode_(layers, now.models, last, value);
  }

 private:
  struct State {
    Models models{};
    Value last{};
  };
  unsigned version_, current_;
  Encode encode_;
  std::map<unsigned, State> states_;
};

struct ColourModels {
  ColourEncoder colours;
  InfraredEncoder infrared;
};
struct ColourValue {
  std::array<std::uint16_t, 3> colour{};
  std::uint16_t infrared = 0;
};
struct ByteModels {
  SlowModels models{256};
};

using ItemEncoder = std::function<void(LayerOut*, unsigned channel, Record)>;

ItemEncoder colour_encoder(unsigned version, unsigned channel, Record first, bool infrared) {
  const auto value = [infrared](Record at) {
    return ColourValue{
        {take<std::uint16_t>(at), take<std::uint16_t>(at + 2), take<std::uint16_t>(at + 4)},
        infrared ? take<std::uint16_t>(at + 6) : std::uint16_t{0}};
  };
  const auto encode = [infrared](LayerOut* layers, ColourModels& models, ColourValue& last,
                                 const ColourValue& now) {
    layers[0].changed |= now.colour != last.colour;
    models.colours.encode(layers[0].out, last.colour, now.colour);
    if (!infrared) return;
    layers[1].changed |= now.infrared != last.infrared;
    models.infrared.encode(layers[1].out, last.infrared, now.infrared);
  };
  OtherItem<ColourModels, ColourValue> item(version, channel, value(first), encode);
  return [=](LayerOut* layers, unsigned in, Record at) mutable { item(layers, in, value(at)); };
}

ItemEncoder wave_encoder(unsigned version, unsigned channel, Record first) {
  using Packet = WavePacketEncoder::Packet;
  const auto value = [](Record at) {
    Packet packet;
    std::copy_n(at, packet.size(), packet.begin());
    return packet;
  };
  const auto encode = [](LayerOut* layers, WavePacketEncoder& models, Packet& last,
                         const Packet& now) {
    layers[0].changed |= now != last;
    models.encode(layers[0].out, last, now);
  };
  OtherItem<WavePacketEncoder, Packet> item(version, channel, value(first), encode);
  return [=](LayerOut* layers, unsigned in, Record at) mutable { item(layers, in, value(at)); };
}

ItemEncoder byte_encoder(unsigned version, unsigned channel, Record first, std::size_t bytes) {
  using Bytes = std::vector<std::uint8_t>;
  const auto encode = [](LayerOut* layers, ByteModels& models, Bytes& last, const Bytes& now) {
    for (unsigned i = 0; i < now.size(); ++i) {
      layers[i].changed |= now[i] != last[i];
      layers[i].out.symbol(models.models[i], static_cast<std::uint8_t>(now[i] - last[i]));
    }
    last = now;
  };
  OtherItem<ByteModels, Bytes> item(version, channel, Bytes(first, first + bytes), encode);
  return [=](LayerOut* layers, unsigned in, Record at) mutable {
    item(layers, in, Bytes(at, at + bytes));
  };
}

struct Item {
  std::size_t bytes, layers;
  ItemEncoder encode;
};

std::vector<Item> item_encoders(const LazOptions& options, Record at) {
  const unsigned format = options.point_format;
  const unsigned version = options.layer_version;
  const Point first(at);
  std::vector<Item> items;
  const auto add = [&](std::size_t bytes, std::size_t layers, ItemEncoder encode) {
    items.push_back({bytes, layers, std::move(encode)});
    at += bytes;
  };
  add(30, 9, [points = Point14Encoder(first)](LayerOut* layers, unsigned, Record point) mutable {
    points.encode(layers, Point(point));
  });
  if (format == 7) add(6, 1, colour_encoder(version, first.channel, at, false));
  if (format == 8 || format == 10) add(8, 2, colour_encoder(version, first.channel, at, true));
  if (format >= 9) add(29, 1, wave_encoder(version, first.channel, at));
  const std::size_t extra = options.extra_bytes;
  if (extra > 0) add(extra, extra, byte_encoder(version, first.channel, at, extra));
  return items;
}

}  // namespace

std::vector<std::uint8_t> encode_layered_chunk(const LazOptions& options,
                                               std::span<const std::uint8_t> records) {
  const std::size_t size = record_bytes(options);
  std::vector<Item> items = item_encoders(options, records.data());
  std::size_t count = 0;
  for (const Item& item : items) count += item.layers;
  Layers layers(count);
  for (std::size_t begin = size; begin < records.size(); begin += size) {
    Record at = &records[begin];
    const unsigned channel = Point(at).channel;
    LayerOut* part = layers.data();
    for (Item& item : items) {
      item.encode(part, channel, at);
      at += item.bytes;
      part += item.layers;
    }
  }
  std::vector<std::uint8_t> chunk(records.begin(), records.begin() + static_cast<long>(size));
  append(chunk, static_cast<std::uint32_t>(records.size() / size));
  std::vector<std::uint8_t> coded;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    std::vector<std::uint8_t> layer;
    if (layers[i].changed || i == 0) layer = layers[i].out.finish();
    append(chunk, static_cast<std::uint32_t>(layer.size()));
    coded.insert(coded.end(), layer.begin(), layer.end());
  }
  chunk.insert(chunk.end(), coded.begin(), coded.end());
  return chunk;
}

}  // namespace orbweave::test
