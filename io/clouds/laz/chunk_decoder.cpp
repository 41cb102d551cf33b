#include "io/clouds/laz/chunk_decoder.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "io/clouds/laz/layered_items.h"
#include "io/clouds/laz/pointwise_items.h"
#include "io/clouds/laz/range_decoder.h"
#include "io/error.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

[[noreturn]] void refuse_short(const RandomAccess& file, std::uint64_t end, std::string expected) {
  throw_bad_input("a chunk of compressed points ends too soon",
                  {.file = file.name(),
                   .place = "byte " + std::to_string(end),
                   .found = "its end",
                   .expected = std::move(expected),
                   .advice = "Copy or download the file again."});
}

std::size_t bytes_of(const std::vector<ItemLayout>& items) {
  std::size_t bytes = 0;
  for (const ItemLayout& item : items) bytes += item.bytes;
  return bytes;
}

/// What both arrangements share: the first record, which is stored as it is.
class RecordDecoder : public ChunkDecoder {
 public:
  RecordDecoder(const RandomAccess& file, const LaszipRecord& record)
      : file_(file), layout_(record.items), first_(bytes_of(record.items)) {}

  void start(const Chunk& chunk) final {
    if (chunk.end - chunk.begin < first_.size()) refuse_short(file_, chunk.end, "its first point");
    file_.read(chunk.begin, first_);
    first_pending_ = true;
    start_items({chunk.begin + first_.size(), chunk.end, chunk.points - 1});
  }

  void decode(std::span<std::byte> records) final {
    std::byte* out = records.data();
    std::byte* const stop = out + records.size();
    if (first_pending_ && out != stop) {
      std::copy(first_.begin(), first_.end(), out);
      out += first_.size();
      first_pending_ = false;
    }
    for (; out != stop; out += first_.size()) decode_items(out);
  }

 protected:
  const RandomAccess& file() const { return file_; }
  const std::vector<ItemLayout>& layout() const { return layout_; }
  const std::vector<std::byte>& first() const { return first_; }

 private:
  /// `rest` is the chunk without its first record; it may hold no points.
  virtual void start_items(const Chunk& rest) = 0;
  virtual void decode_items(std::byte* out) = 0;

  const RandomAccess& file_;
  std::vector<ItemLayout> layout_;
  std::vector<std::byte> first_;
  bool first_pending_ = false;
};

class PointwiseDecoder final : public RecordDecoder {
 public:
  PointwiseDecoder(const RandomAccess& file, const LaszipRecord& record)
      : RecordDecoder(file, record) {
    for (const ItemLayout& item : layout()) items_.push_back(make_pointwise_item(item));
  }
  std::uint64_t position() const override { return opened_ ? in_.position() : begin_; }

 private:
  void start_items(const Chunk& rest) override {
    const std::byte* part = first().data();
    for (std::size_t i = 0; i < items_.size(); part += layout()[i++].bytes) items_[i]->start(part);
    // Encoders close even the stream of a lone point; one that does not does no harm.
    opened_ = rest.points > 0 || rest.begin < rest.end;
    begin_ = rest.begin;
    if (opened_) in_.open(file(), rest.begin, rest.end);
  }
  void decode_items(std::byte* out) override {
    for (std::size_t i = 0; i < items_.size(); out += layout()[i++].bytes)
      items_[i]->decode(in_, out);
  }

  std::vector<std::unique_ptr<PointwiseItem>> items_;
  RangeDecoder in_;
  bool opened_ = false;
  std::uint64_t begin_ = 0;
};

class LayeredDecoder final : public RecordDecoder {
 public:
  LayeredDecoder(const RandomAccess& file, const LaszipRecord& record)
      : RecordDecoder(file, record) {
    std::size_t layers = 0;
    for (const ItemLayout& item : layout()) {
      items_.push_back(make_layered_item(item));
      layers += items_.back()->layers();
    }
    layers_.resize(layers);
  }
  std::uint64_t position() const override { return end_; }

 private:
  void start_items(const Chunk& rest) override;
  void open_layers(const Chunk& rest);
  void decode_items(std::byte* out) override {
    for (std::size_t i = 0; i < items_.size(); out += layout()[i++].bytes)
      items_[i]->decode(out, channel_);
  }

  std::vector<std::unique_ptr<LayeredItem>> items_;
  std::vector<Layer> layers_;
  unsigned channel_ = 0;
  std::uint64_t end_ = 0;  ///< of the last layer
};

void LayeredDecoder::start_items(const Chunk& rest) {
  open_layers(rest);
  const std::byte* part = first().data();
  std::span<Layer> layers(layers_);
  for (std::size_t i = 0; i < items_.size(); part += layout()[i++].bytes) {
    items_[i]->start(part, layers.first(items_[i]->layers()), channel_);
    layers = layers.subspan(items_[i]->layers());
  }
}

/// The number of points again, which the table of chunks knows better, the length of every layer,
/// and then the layers.
void LayeredDecoder::open_layers(const Chunk& rest) {
  std::vector<std::byte> lengths(4 + 4 * layers_.size());
  if (rest.end - rest.begin < lengths.size())
    refuse_short(file(), rest.end, "the lengths of " + std::to_string(layers_.size()) + " layers");
  file().read(rest.begin, lengths);
  end_ = rest.begin + lengths.size();
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const auto bytes = load_little<std::uint32_t>(lengths.data() + 4 + 4 * i);
    if (bytes > rest.end - end_)
      refuse_short(file(), rest.end,
                   "layer " + std::to_string(i) + " of " + std::to_string(bytes) +
                       " bytes from byte " + std::to_string(end_) + " on");
    // Every point has something in the first layer.
    layers_[i].present = rest.points > 0 && (bytes > 0 || i == 0);
    if (layers_[i].present) layers_[i].in.open(file(), end_, end_ + bytes);
    end_ += bytes;
  }
}

}  // namespace

std::unique_ptr<ChunkDecoder> make_chunk_decoder(const RandomAccess& file,
                                                 const LaszipRecord& record) {
  if (record.arrangement == Arrangement::kLayers)
    return std::make_unique<LayeredDecoder>(file, record);
  return std::make_unique<PointwiseDecoder>(file, record);
}

}  // namespace orbweave::laz
