// How points lie in bins and spill files.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "io/point_cloud.h"
#include "io/system/running_checksum.h"
#include "partition/bin_extent.h"

namespace orbweave {

/// A point as it lies in a block: position, normal, attributes, without padding.
struct RecordLayout {
  bool has_normals = false;
  bool single_normals = false;
  std::size_t normal_bytes = 0;
  std::size_t attribute_bytes = 0;
  std::size_t bytes = 0;

  explicit RecordLayout(const PointSchema& schema)
      : has_normals(schema.has_normals),
        single_normals(schema.normal_type == ScalarType::kFloat32),
        normal_bytes(has_normals ? 3 * size_of(schema.normal_type) : 0),
        attribute_bytes(schema.attribute_bytes()),
        bytes(sizeof(Vec3) + normal_bytes + attribute_bytes) {}

  void pack(const PointCloud& cloud, std::size_t i, std::byte* to) const {
    std::memcpy(to, &cloud.positions[i], sizeof(Vec3));
    to += sizeof(Vec3);
    if (has_normals) {
      const Vec3& n = cloud.normals[i];
      const float narrow[3] = {static_cast<float>(n.x), static_cast<float>(n.y),
                               static_cast<float>(n.z)};
      std::memcpy(to, single_normals ? static_cast<const void*>(narrow) : &n, normal_bytes);
      to += normal_bytes;
    }
    if (attribute_bytes > 0)
      std::memcpy(to, cloud.attributes.data() + i * attribute_bytes, attribute_bytes);
  }

  /// Appends the points of whole records.
  void unpack(std::span<const std::byte> records, PointCloud& cloud) const {
    const std::size_t first = cloud.size();
    resize(cloud, first + records.size() / bytes);
    unpack_at(records, cloud, first);
  }

  /// Makes the columns of the layout this long.
  void resize(PointCloud& cloud, std::size_t points) const {
    cloud.positions.resize(points);
    if (has_normals) cloud.normals.resize(points);
    cloud.attributes.resize(points * attribute_bytes);
  }

  /// The points of whole records from point `first` on, which the cloud has room for. Thread-safe
  /// for records of different points.
  void unpack_at(std::span<const std::byte> records, PointCloud& cloud, std::size_t first) const {
    const std::size_t end = first + records.size() / bytes;
    const std::byte* from = records.data();
    for (std::size_t i = first; i < end; ++i, from += bytes) {
      std::memcpy(&cloud.positions[i], from, sizeof(Vec3));
      if (has_normals) cloud.normals[i] = unpack_normal(from + sizeof(Vec3));
      if (attribute_bytes > 0)
        std::memcpy(cloud.attributes.data() + i * attribute_bytes,
                    from + sizeof(Vec3) + normal_bytes, attribute_bytes);
    }
  }

 private:
  Vec3 unpack_normal(const std::byte* from) const {
    Vec3 normal;
    if (!single_normals) {
      std::memcpy(&normal, from, sizeof normal);
      return normal;
    }
    float narrow[3];
    std::memcpy(narrow, from, sizeof narrow);
    return {narrow[0], narrow[1], narrow[2]};
  }
};

/// The records of a piece of a spill file, about a mebibyte at a time: read(offset, out) fills
/// `out`, visit(records) gets it. False where the checksum is another one in the end.
template <class Read, class Visit>
bool visit_extent(const BinExtent& extent, std::size_t record_bytes, const Read& read,
                  const Visit& visit) {
  constexpr std::size_t kPieceBytes = std::size_t{1} << 20;
  const std::size_t piece_bytes =
      std::max<std::size_t>(kPieceBytes / record_bytes, 1) * record_bytes;
  std::vector<std::byte> piece;
  RunningChecksum checksum;
  for (std::uint64_t done = 0; done < extent.bytes; done += piece.size()) {
    piece.resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(piece_bytes, extent.bytes - done)));
    read(extent.offset + done, std::span(piece));
    checksum.add(piece.data(), piece.size());
    visit(std::span<const std::byte>(piece));
  }
  return checksum.value() == extent.checksum;
}

}  // namespace orbweave
