// What the readers' fuzz targets share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "io/error.h"
#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave::fuzz {

inline std::span<const std::byte> bytes_of(const std::uint8_t* data, std::size_t size) {
  return std::as_bytes(std::span(data, size));
}

inline ByteReader reader_of(std::span<const std::byte> bytes) {
  return ByteReader(memory_byte_source(bytes, "input"));
}

/// Reads a source to its end and checks what every source promises of its batches.
inline void drain(PointSource& source, std::size_t capacity) {
  PointCloud batch;
  std::uint64_t points = 0;
  while (source.read(batch, capacity)) {
    const bool whole = batch.size() <= capacity && batch.schema == source.schema() &&
                       batch.normals.size() == (batch.schema.has_normals ? batch.size() : 0) &&
                       batch.attributes.size() == batch.size() * batch.schema.attribute_bytes();
    if (!whole) throw std::logic_error("a batch breaks the invariant of PointCloud");
    points += batch.size();
  }
  for (const auto& [reason, rows] : source.left_out()) points += rows;
  if (source.declared_points().value_or(0) > points)
    throw std::logic_error("fewer points than declared, and no error");
}

}  // namespace orbweave::fuzz
