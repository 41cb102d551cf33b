// The first 30 bytes of point formats 6 to 10, in nine layers.
//
// Source: format of LASzip (docs/dev/laz.md), item POINT14.
#pragma once

#include <memory>

#include "io/clouds/laz/layered_item.h"

namespace orbweave::laz {

/// Versions 3 and 4 are the same for this item.
std::unique_ptr<LayeredItem> make_point14();

}  // namespace orbweave::laz
