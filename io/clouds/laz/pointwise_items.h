// The parts of a point record in files of compressors 1 and 2: all parts of a point follow one
// another in one coded stream.
//
// Source: format of LASzip (docs/dev/laz.md), items POINT10, GPSTIME11, RGB12 and BYTE, version 2,
// and WAVEPACKET13, version 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "io/clouds/laz/laszip_record.h"
#include "io/clouds/laz/range_decoder.h"

namespace orbweave::laz {

/// One part of a record.
class PointwiseItem {
 public:
  virtual ~PointwiseItem() = default;
  /// Begins a chunk, whose first point is stored as it is; `first` is this part of it.
  virtual void start(const std::byte* first) = 0;
  /// Writes this part of the next point.
  virtual void decode(RangeDecoder& in, std::byte* out) = 0;
};

/// `item` is one that parse_laszip_record() lets through for compressors 1 and 2.
std::unique_ptr<PointwiseItem> make_pointwise_item(const ItemLayout& item);

}  // namespace orbweave::laz
