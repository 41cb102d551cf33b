// What a vertex of a mesh tells of the point that it was made from, where that is asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// What decided the side of a normal. The numbers are those of the files (docs/output.md).
enum class NormalOrigin : std::uint8_t {
  kGiven = 0,  ///< the scan has the normal
  kScanner = 1,
  kViewpoint = 2,
  kUp = 3,
  kPropagated = 4,
  kGround = 5,
  kInward = 6,
  kNoSide = 7,
  kInvented = 255  ///< the vertex is part of the patch of a hole, and no point was there
};

struct VertexQuality {
  float spacing = -1.0F;  ///< mean distance to the six nearest points of the scans; -1: not known
  float noise = -1.0F;    ///< root mean square off the surface around it; -1: not known
  float moved = 0.0F;     ///< way that cleaning moved it; -1: no point was there
  NormalOrigin normal = NormalOrigin::kNoSide;
};

/// The attributes that carry it: quality_spacing, quality_noise, quality_moved and quality_normal.
const std::vector<AttributeField>& quality_fields();

/// Byte offset of the quality in an attribute row; nothing where the schema has none.
std::optional<std::size_t> quality_offset(const PointSchema& schema);

void put_quality(const VertexQuality& quality, std::byte* at);
VertexQuality quality_at(const std::byte* at);

/// Of vertices that were invented, attribute values as numbers (vertices x attributes): the quality
/// says so in place of what was interpolated.
void mark_invented(const PointSchema& schema, std::span<double> values);

}  // namespace orbweave
