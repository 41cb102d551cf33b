// The parts of a point record in files of compressor 3: every attribute has a coded stream of its
// own, a layer, and every scanner channel its own statistics.
//
// Source: format of LASzip (docs/laz.md), items POINT14, RGB14, RGBNIR14, WAVEPACKET14 and BYTE14,
// versions 3 and 4.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "io/laz/laszip_record.h"
#include "io/laz/range_decoder.h"

namespace orbweave::laz {

/// The coded stream of one attribute. An attribute that no point of the chunk changes has none.
struct Layer {
  RangeDecoder in;
  bool present = false;
};

/// One part of a record. The scanner channel of a point comes with its first part and is passed on
/// to the others.
class LayeredItem {
 public:
  virtual ~LayeredItem() = default;
  virtual std::size_t layers() const = 0;
  /// Begins a chunk, whose first point is stored as it is; `first` is this part of it. `layers`
  /// are this part's and must outlive the chunk.
  virtual void start(const std::byte* first, std::span<Layer> layers, unsigned& channel) = 0;
  /// Writes this part of the next point.
  virtual void decode(std::byte* out, unsigned& channel) = 0;
};

/// `item` is one that parse_laszip_record() lets through for compressor 3.
std::unique_ptr<LayeredItem> make_layered_item(const ItemLayout& item);

}  // namespace orbweave::laz
