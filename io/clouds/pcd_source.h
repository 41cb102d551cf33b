// Clouds in the PCD format of the Point Cloud Library as point sources.
#pragma once

#include <memory>

#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// True where the bytes at hand begin like a PCD header.
bool looks_like_pcd(ByteReader& reader);

/// Opens a PCD file, versions 0.5 to 0.7: ascii, binary (little-endian) and binary_compressed.
/// x, y, z are the position, normal_x, normal_y, normal_z the normal, rgb and rgba are taken apart
/// into red, green, blue (and, of rgba, alpha); every other field is an attribute of its own type.
/// Points stay in the coordinates they are stored in; scanner() is the translation of VIEWPOINT,
/// in those coordinates, where VIEWPOINT is not the default.
/// binary_compressed is stored field by field: its points are decompressed into memory at the
/// first read(); the other two stream.
/// Throws Error (bad input) with file and place.
std::unique_ptr<PointSource> open_pcd_source(ByteReader reader);

}  // namespace orbweave
