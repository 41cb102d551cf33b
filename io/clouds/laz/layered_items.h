// The parts of a point record in files of compressor 3: every attribute has a coded stream of its
// own, a layer, and every scanner channel its own statistics.
//
// Source: format of LASzip (docs/dev/laz.md), items POINT14, RGB14, RGBNIR14, WAVEPACKET14 and
// BYTE14, versions 3 and 4.
#pragma once

#include <memory>

#include "io/clouds/laz/laszip_record.h"
#include "io/clouds/laz/layered_item.h"

namespace orbweave::laz {

/// `item` is one that parse_laszip_record() lets through for compressor 3.
std::unique_ptr<LayeredItem> make_layered_item(const ItemLayout& item);

}  // namespace orbweave::laz
