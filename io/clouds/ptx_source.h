// Terrestrial scans in Leica's PTX text format as a point source.
#pragma once

#include <functional>
#include <memory>

#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// True where the first ten lines at hand are a PTX header.
bool looks_like_ptx(ByteReader& reader);

/// Opens a PTX file: any number of scans, each a header of ten lines (columns; rows; the
/// registered position of the scanner; its three axes; a 4x4 matrix) and columns * rows lines
/// `x y z intensity [red green blue]`. Points are transformed in double, world = [x y z 1] *
/// matrix; rows `0 0 0` are pulses without return, counted in left_out(). scanner() is the origin
/// under the matrix; no batch mixes scans. Attributes are intensity (float32) and, where every scan
/// has them, red, green and blue (uint8): `again`, which opens the same bytes a second time, serves
/// to look ahead for that; without it (a pipe) a later scan without colours is an error.
///
/// A header whose axes are all zero was made up by a converter: its counts and its scanner's place
/// are not believed. In any other file that ends before its rows do, the last read() throws.
/// Format: P. Bourke, PTX plain text data format, 2015, after Leica's description.
/// Throws Error (bad input) with file and line.
std::unique_ptr<PointSource> open_ptx_source(ByteReader reader,
                                             const std::function<ByteReader()>& again = nullptr);

}  // namespace orbweave
