// One part of a point record in files of compressor 3, and its coded streams.
#pragma once

#include <cstddef>
#include <span>

#include "io/clouds/laz/range_decoder.h"

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

}  // namespace orbweave::laz
