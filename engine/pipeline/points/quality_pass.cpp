#include "engine/pipeline/points/quality_pass.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "engine/geometry/neighbor_search.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/points/point_views.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kSpacingNeighbors = 6;

bool is_of_quality(const AttributeField& field) {
  return std::any_of(quality_fields().begin(), quality_fields().end(),
                     [&](const AttributeField& own) { return own.name == field.name; });
}

/// The quality comes before the view, which has to be last.
PointSchema with_quality(const PointSchema& schema) {
  PointSchema result = schema;
  std::erase_if(result.attributes, is_of_quality);
  const bool has_view = view_offset(schema).has_value();
  const auto at =
      result.attributes.end() - (has_view ? static_cast<std::ptrdiff_t>(view_fields().size()) : 0);
  result.attributes.insert(at, quality_fields().begin(), quality_fields().end());
  return result;
}

/// Mean distance to the nearest six others of each of points [begin, end) of the pass.
std::vector<float> spacings_of(const PassPoints& points, double reach, const StopToken& stop) {
  std::vector<float> spacings(points.own.size(), -1.0F);
  const NeighborSearch search(points.positions);
  NeighborSearch::Query query;
  for (std::uint32_t i = points.begin; i < points.end; ++i) {
    if (i % kStopBlock == 0) stop.check();
    query.find(search, i, i + 1, kSpacingNeighbors, squared_reach(reach));
    const std::span<const double> squared = query.squared_of(i);
    double sum = 0.0;
    for (const double one : squared) sum += std::sqrt(one);
    if (!squared.empty())
      spacings[i - points.begin] = static_cast<float>(sum / static_cast<double>(squared.size()));
  }
  return spacings;
}

/// Copies what stays of an attribute row; returns where the next begins.
class RowCopy {
 public:
  RowCopy(const PointSchema& from, const PointSchema& to) : bytes_(from.attribute_bytes()) {
    std::size_t offset = 0;
    for (const AttributeField& field : from.attributes) {
      if (!is_of_quality(field)) kept_.emplace_back(offset, size_of(field.type));
      offset += size_of(field.type);
    }
    quality_ = quality_offset(to).value_or(0);
  }

  void copy(const PointCloud& from, std::size_t row, const VertexQuality& quality,
            std::byte* to) const {
    const std::byte* begin = from.attributes.data() + row * bytes_;
    std::size_t filled = 0;
    const auto put_own = [&] {
      put_quality(quality, to + filled);
      for (const AttributeField& field : quality_fields()) filled += size_of(field.type);
    };
    for (const auto& [offset, size] : kept_) {
      if (filled == quality_) put_own();
      std::memcpy(to + filled, begin + offset, size);
      filled += size;
    }
    if (filled == quality_) put_own();
  }

 private:
  std::size_t bytes_, quality_;
  std::vector<std::pair<std::size_t, std::size_t>> kept_;  // offset and size
};

/// Where the points were seen from is known of all of them, or of one.
NormalOrigin origin_of(NormalOrigin origin, const PointCloud& points, std::size_t i,
                       std::optional<std::size_t> view) {
  if (origin != NormalOrigin::kScanner || !view) return origin;
  return view_of(points, i, *view).known() ? origin : NormalOrigin::kNoSide;
}

PointCloud with_qualities(PassPoints&& points, const LocalCleaning& cleaning, NormalOrigin origin,
                          double reach, const StopToken& stop) {
  const std::vector<float> spacings = spacings_of(points, reach, stop);
  const std::vector<LocalNoise> noise = cleaning.noise_of(points.own.positions);
  PointCloud result = std::move(points.own);
  const PointCloud before{result.schema, {}, {}, std::move(result.attributes)};
  result.schema = with_quality(before.schema);
  const std::size_t bytes = result.schema.attribute_bytes();
  result.attributes.assign(result.size() * bytes, {});
  const std::optional<std::size_t> view = view_offset(before.schema);
  const RowCopy rows(before.schema, result.schema);
  for (std::size_t i = 0; i < result.size(); ++i)
    rows.copy(before, i, {spacings[i], noise[i].noise, 0.0F, origin_of(origin, before, i, view)},
              result.attributes.data() + i * bytes);
  return result;
}

}  // namespace

RawPass quality_pass(const RawCloud& cloud, const LocalCleaning& cleaning, NormalOrigin origin,
                     const StopToken& stop) {
  const double reach = cloud.partition.normal_radius;
  return {.stage = directory_of(Stage::kQuality),
          .options = key_line("layout of quality", "1") +
                     key_line("origin of normals", std::to_string(static_cast<int>(origin))) +
                     key_line("reach of spacings", format_exact(reach)),
          .halo = reach,
          .schema = with_quality(cloud.schema),
          .work = [cleaning, origin, reach, &stop](PassPoints&& points) {
            return PassResult{with_qualities(std::move(points), cleaning, origin, reach, stop)};
          }};
}

void add_moves(PointCloud& points, std::span<const Vec3> after) {
  const std::optional<std::size_t> offset = quality_offset(points.schema);
  if (!offset) return;
  const std::size_t bytes = points.schema.attribute_bytes();
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::byte* const at = points.attributes.data() + i * bytes + *offset;
    VertexQuality quality = quality_at(at);
    quality.moved += static_cast<float>(norm(after[i] - points.positions[i]));
    put_quality(quality, at);
  }
}

}  // namespace orbweave
