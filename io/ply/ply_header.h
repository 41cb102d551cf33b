// What a PLY file's header says.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/point_cloud.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

enum class PlyFormat { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;      ///< of the value, or of a list's values
  bool is_list = false;                        ///< a count, then the counted values
  ScalarType count_type = ScalarType::kUint8;  ///< of a list's count
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Bytes of a row's scalar values without padding; in binary files without lists, of a row.
  std::size_t scalar_bytes() const;
  /// Fewest bytes that a row takes in a binary file.
  std::size_t least_row_bytes() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;

  const PlyElement* find(const std::string& element) const;
};

/// Reads a header; the reader then stands at the first row. Throws Error (bad input) with file
/// and line for anything that is no PLY header.
PlyHeader read_ply_header(ByteReader& reader);

/// Throws Error (bad input) when a binary file is too short for what its header promises, as far
/// as its size tells; call it right after read_ply_header.
void check_ply_length(const ByteReader& reader, const PlyHeader& header);

/// The list of a face's corners: "vertex_indices" or "vertex_index"; its position among the
/// element's properties. Of faces and of triangle strips; nothing for other elements.
std::optional<std::size_t> find_corner_list(const PlyElement& faces);

/// Whether the rows of a face element are strips: every vertex makes a triangle with the two before
/// it, turned over every second time; -1 ends a strip. Files of Stanford's repository have one row
/// with all strips.
bool are_strips(const PlyElement& faces);

}  // namespace orbweave
