#include "engine/pipeline/output/picture_stage.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/pipeline/output/picture_parts.h"
#include "engine/pipeline/stage/writer_options.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "io/report/picture.h"
#include "io/report/picture_palette.h"
#include "io/report/picture_up.h"
#include "io/report/point_colors.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

using Corners = std::array<Vec3, 3>;

/// What the fronts of triangles are coloured by, where that is more than whether they fill a hole.
struct SurfaceColors {
  std::optional<PointColors> points;
  std::optional<EdgeComponents> components;
  bool undersampled = false;
};

/// Triangles as they are drawn.
struct DrawnTriangles {
  std::vector<Corners> corners;
  std::vector<Rgb> fronts;         ///< colours, where each triangle has its own
  std::vector<std::int32_t> hole;  ///< ids, where these decide; empty: none fills a hole
};

template <class T>
std::span<const T> part_of_span(const std::vector<T>& all, std::size_t first, std::size_t count) {
  return all.empty() ? std::span<const T>() : std::span<const T>(all).subspan(first, count);
}

/// The samples of a picture keep the nearest triangle whatever the order of drawing.
void draw_on_all_threads(const DrawnTriangles& drawn, MeshPicture& picture) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, drawn.corners.size(), 4096), [&](const auto& range) {
        const auto corners = part_of_span(drawn.corners, range.begin(), range.size());
        const auto fronts = part_of_span(drawn.fronts, range.begin(), range.size());
        if (!fronts.empty())
          picture.draw_colored(corners, fronts);
        else
          picture.draw(corners, part_of_span(drawn.hole, range.begin(), range.size()));
      });
}

std::vector<Rgb> colors_of(std::span<const std::uint32_t> ranks) {
  std::vector<Rgb> colors;
  colors.reserve(ranks.size());
  for (const std::uint32_t rank : ranks) colors.push_back(component_color(rank));
  return colors;
}

/// A triangle has the colour of its first vertex, which the chunk owns: the picture is the same
/// however the points were cut into chunks.
std::vector<Rgb> colors_of_first_vertices(const ChunkPart& part, const PointColors& colors) {
  std::vector<Rgb> fronts;
  fronts.reserve(part.triangles.size());
  for (const Triangle& t : part.triangles) fronts.push_back(colors.of(part.points, t[0]));
  return fronts;
}

/// Likewise, where sampling is too sparse.
std::vector<Rgb> colors_of_sampling(const ChunkPart& part) {
  std::vector<Rgb> fronts;
  fronts.reserve(part.triangles.size());
  for (const Triangle& t : part.triangles)
    fronts.push_back(part.undersampled.at(t[0]) != 0 ? kUndersampledColor : kSurfaceColor);
  return fronts;
}

/// The triangles of a chunk that no patch replaces.
DrawnTriangles drawn_of_chunk(const StageRunner& runner, const ExportInputs& inputs,
                              const SurfaceColors& colors, ChunkId chunk) {
  const ChunkPart part = load_chunk_part(
      runner, inputs, chunk, colors.points ? PartPoints::kAttributes : PartPoints::kPositions);
  DrawnTriangles drawn;
  drawn.corners.reserve(part.triangles.size());
  for (const Triangle& t : part.triangles)
    drawn.corners.push_back({part.position(t[0]), part.position(t[1]), part.position(t[2])});
  if (colors.points) drawn.fronts = colors_of_first_vertices(part, *colors.points);
  if (colors.components) drawn.fronts = colors_of(colors.components->ranks(chunk, part.triangles));
  if (colors.undersampled) drawn.fronts = colors_of_sampling(part);
  return drawn;
}

/// Consecutive batches of patches, and the vertices of the scanned surface at their rims.
struct PatchGroup {
  ChunkId begin = 0, end = 0;
  std::vector<std::uint64_t> rim;  ///< ascending
  std::vector<Vec3> positions;     ///< of the rim
};

/// Takes batches from `begin` on, until their rims have a million vertices.
PatchGroup group_from(const StageRunner& runner, const FilledHoles& holes, ChunkId begin) {
  constexpr std::size_t kMostVertices = std::size_t{1} << 20;
  PatchGroup group{begin, begin, {}, {}};
  while (group.end < holes.new_triangles.size() && group.rim.size() < kMostVertices) {
    runner.stop.check();
    for (const Triangle64& t : load_patch_batch(runner.store, group.end++).triangles)
      for (const std::uint64_t vertex : t)
        if (vertex < kNewVertex) group.rim.push_back(vertex);
    std::sort(group.rim.begin(), group.rim.end());
    group.rim.erase(std::unique(group.rim.begin(), group.rim.end()), group.rim.end());
  }
  return group;
}

/// Patches touch chunks in any order, so each chunk is read once for all of them.
void place_rims(const StageRunner& runner, const Partition& partition, PatchGroup& group) {
  group.positions.reserve(group.rim.size());
  while (group.positions.size() < group.rim.size()) {
    runner.stop.check();
    const ChunkId chunk = partition.chunk_of(group.rim[group.positions.size()]);
    PointSchema positions_alone;
    positions_alone.position_type = partition.schema.position_type;
    const std::vector<Vec3> own =
        load_points(runner.store, chunk, positions_alone, partition.stage).positions;
    for (std::size_t i = group.positions.size();
         i < group.rim.size() && group.rim[i] < partition.first_vertex[chunk + 1]; ++i)
      group.positions.push_back(own[group.rim[i] - partition.first_vertex[chunk]]);
  }
}

/// `chunks`: parts of the mesh before the first batch.
void draw_group(const StageRunner& runner, const PatchGroup& group, const SurfaceColors& colors,
                std::size_t chunks, MeshPicture& picture) {
  for (ChunkId batch = group.begin; batch < group.end; ++batch) {
    runner.stop.check();
    const PatchBatch patches = load_patch_batch(runner.store, batch);
    const auto position = [&](std::uint64_t vertex) {
      if (vertex >= kNewVertex) return patches.positions[vertex - kNewVertex];
      const auto at = std::lower_bound(group.rim.begin(), group.rim.end(), vertex);
      return group.positions[static_cast<std::size_t>(at - group.rim.begin())];
    };
    DrawnTriangles drawn;
    for (const Triangle64& t : patches.triangles)
      drawn.corners.push_back({position(t[0]), position(t[1]), position(t[2])});
    if (colors.components)
      drawn.fronts =
          colors_of(colors.components->ranks(chunks + batch, part_of(patches).triangles));
    else
      drawn.hole = patches.hole;
    draw_on_all_threads(drawn, picture);
  }
}

/// The scanned surface chunk by chunk, then the patches. `is_first`: progress counts the chunks of
/// the first time alone.
void draw_mesh(const ExportInputs& inputs, const SurfaceColors& colors, StageRunner& runner,
               MeshPicture& picture, bool is_first = false) {
  const auto chunks = static_cast<ChunkId>(inputs.partition.octree.chunks().size());
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    runner.stop.check();
    draw_on_all_threads(drawn_of_chunk(runner, inputs, colors, chunk), picture);
    if (is_first) runner.progress.advance(1);
  }
  for (ChunkId batch = 0; batch < inputs.holes.new_triangles.size();) {
    PatchGroup group = group_from(runner, inputs.holes, batch);
    place_rims(runner, inputs.partition, group);
    draw_group(runner, group, colors, chunks, picture);
    batch = group.end;
  }
}

/// The colours of the scan; empty, with a note, where it has none.
std::optional<PointColors> point_colors(const Partition& partition, StageRunner& runner) {
  PointColors colors(partition.schema);
  if (!colors.any()) {
    runner.note(kNoPointColors);
    return std::nullopt;
  }
  PointSchema schema = partition.schema;
  schema.has_normals = false;
  const auto chunks = static_cast<ChunkId>(partition.octree.chunks().size());
  for (ChunkId chunk = 0; colors.needs_survey() && chunk < chunks; ++chunk) {
    runner.stop.check();
    colors.survey(load_points(runner.store, chunk, schema, partition.stage));
  }
  colors.finish();
  return colors;
}

SurfaceColors surface_colors(const ExportInputs& inputs, StageRunner& runner) {
  SurfaceColors colors;
  const PictureColors wanted = runner.job.output.picture_colors;
  if (wanted == PictureColors::kPoints) colors.points = point_colors(inputs.partition, runner);
  colors.undersampled = wanted == PictureColors::kUndersampled;
  if (wanted == PictureColors::kComponent) colors.components = stored_components(runner, inputs);
  return colors;
}

std::vector<LegendEntry> legend_of(const SurfaceColors& colors, const PictureOptions& options,
                                   const FilledHoles& holes) {
  if (colors.components) return component_legend(colors.components->triangles());
  const bool has_patches =
      std::ranges::any_of(holes.new_triangles, [](std::uint64_t count) { return count > 0; });
  std::vector<LegendEntry> entries = surface_legend(options, has_patches);
  if (colors.points) entries.front() = colors.points->legend();
  if (colors.undersampled)
    entries.insert(entries.begin() + 1,
                   {kUndersampledColor, kUndersampledColor, "undersampled surface"});
  return entries;
}

}  // namespace

void draw_picture(const ExportInputs& inputs, const Box& bounds, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const auto chunks = static_cast<ChunkId>(partition.octree.chunks().size());
  const StageClock clock(runner, Stage::kPicture, chunks, "chunks");
  const OutputOptions& output = runner.job.output;
  PictureOptions options;
  options.up = picture_up(runner.job, runner.job.files, partition.coordinate_system);
  options.patch_color = output.patch_color;
  if (output.picture_colors == PictureColors::kConfidence)
    options.confidence = confidence_of_patches(inputs.holes.holes);
  const SurfaceColors colors = surface_colors(inputs, runner);
  MeshPicture picture(bounds, options);
  picture.set_legend(legend_of(colors, options, inputs.holes));
  const PictureBacks backs = output.picture_backs;
  if (backs == PictureBacks::kCulled) picture.leave_out_backs();
  draw_mesh(inputs, colors, runner, picture, true);
  if (backs == PictureBacks::kAuto)
    picture.look_at_fronts(may_be_interior(runner.job, runner.job.files),
                           [&] { draw_mesh(inputs, colors, runner, picture); });
  picture.show_specks([&] { draw_mesh(inputs, colors, runner, picture); });
  picture.write_png(output.picture);
}

}  // namespace orbweave
