#include "engine/levels/simplified_mesh.h"

#include <algorithm>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/levels/chosen_vertices.h"
#include "engine/levels/level_maker.h"
#include "engine/levels/node_mesh.h"
#include "engine/levels/simplify.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/patch_confidence.h"
#include "io/system/spool_file.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBatch = std::size_t{1} << 16;

/// A node of the cut.
struct Piece {
  std::uint32_t node = 0;
  std::uint64_t weight = 0;  ///< its triangles of the mesh
  std::uint64_t share = 0;   ///< triangles that it may have; those of the node at first
  bool is_stuck = false;     ///< cannot become as small as its share
  std::uint64_t triangles = 0;
  double error = 0.0;
  std::uint64_t offset = 0;  ///< in the spool file
  std::uint64_t bytes = 0;
};

/// `total` over the pieces that are not stuck, by their weights. Exact: of as many as they weigh
/// together, each gets its own weight.
std::vector<std::uint64_t> shares_of(std::span<const Piece> pieces, std::uint64_t total) {
  std::uint64_t weight = 0;
  for (const Piece& piece : pieces) weight += piece.is_stuck ? 0 : piece.weight;
  std::vector<std::uint64_t> shares(pieces.size(), 0);
  std::uint64_t left = total;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (pieces[i].is_stuck) continue;
    // 128 bits because the product may not fit 64.
    shares[i] =
        static_cast<std::uint64_t>(static_cast<__uint128_t>(total) * pieces[i].weight / weight);
    left -= shares[i];
  }
  for (std::size_t i = 0; i < pieces.size() && left > 0; ++i) {
    if (pieces[i].is_stuck) continue;
    ++shares[i];
    --left;
  }
  return shares;
}

/// All pieces of the simplified mesh; their meshes, without rows of vertices, on disk.
struct Pieces {
  explicit Pieces(const fs::path& directory) : spool(directory) {}
  std::vector<Piece> all;
  SpoolFile spool;
  Box bounds;  ///< of the mesh that was read

  NodeMesh read(const Piece& piece) const {
    std::vector<std::byte> bytes(piece.bytes);
    spool.read(piece.offset, bytes);
    return unpacked(bytes, 0);
  }
};

/// Simplifies the pieces of a cut.
class PieceMaker {
 public:
  PieceMaker(const LevelMaker& maker, Pieces& pieces, const StopToken& stop)
      : maker_(maker), pieces_(pieces), stop_(stop) {
    pieces.bounds = maker.bounds();
    for (const std::uint32_t node : maker.cut()) {
      Piece piece;
      piece.node = node;
      piece.weight = maker.levels().nodes[node].triangles;
      pieces.all.push_back(piece);
    }
  }

  /// Simplifies every piece as far as the error allows.
  void make_within(double error) {
    maker_.on_threads(pieces_.all.size(), [&](std::size_t i) {
      stop_.check();
      Piece& piece = pieces_.all[i];
      const NodeMesh mesh = maker_.node(piece.node);
      const std::vector<Vec3> positions = maker_.positions(mesh);
      store(piece, mesh, positions,
            simplify_within(positions, mesh.triangles, maker_.border_vertices(mesh),
                            error - error_of(piece)));
    });
  }

  /// Simplifies to `total` triangles together. Where pieces cannot become as small as their share,
  /// the others become smaller.
  void make_with(std::uint64_t total) {
    constexpr int kMostRounds = 6;
    for (int round = 0; round < kMostRounds; ++round) {
      std::uint64_t stuck = 0;
      for (const Piece& piece : pieces_.all) stuck += piece.is_stuck ? piece.triangles : 0;
      simplify_to(shares_of(pieces_.all, total - std::min(total, stuck)));
      if (!find_stuck()) return;
    }
  }

 private:
  double error_of(const Piece& piece) const { return maker_.levels().facts[piece.node].error; }

  void simplify_to(const std::vector<std::uint64_t>& shares) {
    maker_.on_threads(pieces_.all.size(), [&](std::size_t i) {
      Piece& piece = pieces_.all[i];
      if (piece.is_stuck || (piece.bytes > 0 && piece.share == shares[i])) return;
      stop_.check();
      piece.share = shares[i];
      const NodeMesh mesh = maker_.node(piece.node);
      const std::vector<Vec3> positions = maker_.positions(mesh);
      store(piece, mesh, positions,
            simplify_between(positions, mesh.triangles, maker_.border_vertices(mesh),
                             {.triangles = static_cast<std::size_t>(shares[i])}));
    });
  }

  /// Whether there is a further piece that is larger than its share.
  bool find_stuck() {
    bool any = false;
    for (Piece& piece : pieces_.all) {
      if (piece.is_stuck || piece.triangles <= piece.share) continue;
      piece.is_stuck = true;
      any = true;
    }
    return any;
  }

  /// Numbers of vertices, triangles and their tags; the rest is read again from the mesh.
  void store(Piece& piece, const NodeMesh& mesh, std::span<const Vec3> positions,
             Simplification simpler) {
    NodeMesh bare;
    bare.vertices = mesh.vertices;
    // What keeps the surface a manifold goes before the count.
    if (!simpler.is_sound) simpler = {mesh.triangles, 0.0, true};
    std::vector<FaceTag> tags =
        simplified_tags(positions, mesh.triangles, mesh.tags, simpler.triangles);
    NodeMesh part = used_part(bare, std::move(simpler.triangles), 0);
    part.tags = std::move(tags);
    const std::vector<std::byte> bytes = packed(part);
    piece.triangles = part.triangles.size();
    piece.error = error_of(piece) + simpler.error;
    piece.offset = pieces_.spool.append(bytes);
    piece.bytes = bytes.size();
  }

  const LevelMaker& maker_;
  Pieces& pieces_;
  const StopToken& stop_;
};

/// Reads the mesh and makes the pieces; what levels take of memory and disk is given back.
void make_pieces(const fs::path& mesh, const SimplifyOptions& options, const SimplifyEvents& events,
                 const StopToken& stop, Pieces& pieces, SimplifiedFacts& facts) {
  LevelEvents of_levels;
  of_levels.read = events.read;
  of_levels.planned = [&](std::uint32_t nodes, const Box&) {
    if (events.planned) events.planned(nodes);
  };
  if (events.made)
    of_levels.done = [&](std::uint32_t, const PointCloud&, const NodeMesh&) { events.made(); };
  // Positions decide. What vertices carry is read again at the end, what faces carry goes along.
  const auto stream = open_mesh_stream(mesh);
  LevelOptions levels = options.levels;
  levels.keeps_tags = stream->has_holes();
  LevelMaker maker(*stream, PointSchema{}, levels, of_levels, stop);
  const auto note_work = [&] {
    facts.work_bytes = maker.disk_bytes() + pieces.spool.bytes();
    facts.nodes_reused = maker.levels().reused;
  };
  facts.vertices_read = maker.levels().vertices;
  facts.triangles_read = maker.levels().triangles;
  facts.nodes = maker.levels().nodes.size();
  const double error = options.target.value;
  if (options.target.kind == SimplifyTarget::Kind::kError) {
    maker.make([&](const LevelNode&, const LevelFacts& made) {
      return made.is_sound && made.error <= error;
    });
    PieceMaker(maker, pieces, stop).make_within(error);
    return note_work();
  }
  facts.most_triangles = most_triangles(options.target, facts.triangles_read);
  const double ratio =
      static_cast<double>(facts.most_triangles) / static_cast<double>(facts.triangles_read);
  maker.make([&](const LevelNode& node, const LevelFacts& made) {
    return made.is_sound &&
           static_cast<double>(made.triangles) >= ratio * static_cast<double>(node.triangles);
  });
  PieceMaker(maker, pieces, stop).make_with(facts.most_triangles);
  note_work();
}

/// Points of a batch that are chosen; `first`: the number of its first one.
PointCloud chosen_of(const PointCloud& batch, std::uint64_t first, const ChosenVertices& chosen) {
  PointCloud kept;
  kept.schema = batch.schema;
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (chosen.is_chosen(first + i)) kept.append(batch, i);
  return kept;
}

void write_vertices(MeshStream& mesh, const ChosenVertices& chosen, MeshWriter& writer,
                    const StopToken& stop) {
  std::uint64_t first = 0;
  for (PointCloud batch; mesh.read_vertices(batch, kBatch);) {
    stop.check();
    const PointCloud kept = chosen_of(batch, first, chosen);
    if (!kept.empty()) writer.write_vertices(kept);
    first += batch.size();
  }
}

std::vector<Triangle64> in_file_numbers(const NodeMesh& piece, const ChosenVertices& chosen) {
  std::vector<std::uint64_t> ranks;
  ranks.reserve(piece.vertices.size());
  for (const std::uint64_t vertex : piece.vertices) ranks.push_back(chosen.rank(vertex));
  std::vector<Triangle64> triangles;
  triangles.reserve(piece.triangles.size());
  for (const Triangle& t : piece.triangles)
    triangles.push_back({ranks[t[0]], ranks[t[1]], ranks[t[2]]});
  return triangles;
}

std::vector<std::int32_t> holes_of(const NodeMesh& piece) {
  std::vector<std::int32_t> holes;
  holes.reserve(piece.tags.size());
  for (const FaceTag& tag : piece.tags) holes.push_back(tag.hole);
  return holes;
}

/// The vertices of all pieces. `confidence`: becomes that of each patch by the id of its hole.
ChosenVertices vertices_of(const Pieces& pieces, SimplifiedFacts& facts,
                           std::map<std::int32_t, float>& confidence) {
  ChosenVertices chosen(facts.vertices_read);
  for (const Piece& piece : pieces.all) {
    facts.triangles += piece.triangles;
    facts.error = std::max(facts.error, piece.error);
    const NodeMesh made = pieces.read(piece);
    for (const std::uint64_t vertex : made.vertices) chosen.choose(vertex);
    for (const FaceTag& tag : made.tags)
      if (tag.hole > 0) confidence.emplace(tag.hole, tag.confidence);
  }
  chosen.number();
  facts.vertices = chosen.count();
  return chosen;
}

/// Faces say how sure patches are where those of the mesh do.
void keep_confidence(const MeshStream& mesh, const std::map<std::int32_t, float>& of_patches,
                     MeshWriterOptions& written) {
  written.confidence.clear();
  written.has_confidence = mesh.has_confidence();
  if (!written.has_confidence || of_patches.empty()) return;
  if (of_patches.rbegin()->first > kMostIdWithConfidence) {
    written.has_confidence = false;
    return;
  }
  for (const auto& [hole, value] : of_patches) note_confidence(written.confidence, hole, value);
}

}  // namespace

std::string missed_limit(const SimplifiedFacts& facts) {
  if (facts.most_triangles == 0 || facts.triangles <= facts.most_triangles) return {};
  return "the mesh cannot be simplified to " + format_count(facts.most_triangles) +
         (facts.most_triangles == 1 ? " triangle" : " triangles") +
         ": borders, rims and handles need more";
}

SimplifiedFacts write_simplified(const fs::path& mesh, const fs::path& target,
                                 const SimplifyOptions& options, const SimplifyEvents& events,
                                 const StopToken& stop) {
  SimplifiedFacts facts;
  Pieces pieces(options.levels.directory);
  make_pieces(mesh, options, events, stop, pieces, facts);
  std::map<std::int32_t, float> confidence;
  const ChosenVertices chosen = vertices_of(pieces, facts, confidence);
  MeshWriterOptions written = options.written(pieces.bounds);
  facts.origin = written.origin;
  const auto stream = open_mesh_stream(mesh);
  facts.fills_holes = !confidence.empty();
  keep_confidence(*stream, confidence, written);
  facts.has_confidence = facts.fills_holes && written.has_confidence;
  const MeshHeader header{.vertices = facts.vertices,
                          .triangles = facts.triangles,
                          .has_hole = stream->has_holes(),
                          .schema = stream->schema()};
  const auto writer = open_mesh_writer(target, header, written);
  if (events.begun) events.begun(facts.triangles);
  write_vertices(*stream, chosen, *writer, stop);
  for (const Piece& piece : pieces.all) {
    stop.check();
    const NodeMesh made = pieces.read(piece);
    const std::vector<Triangle64> triangles = in_file_numbers(made, chosen);
    writer->write_triangles(triangles, holes_of(made));
    if (events.written) events.written(triangles.size());
  }
  writer->finish();
  facts.bytes = writer->bytes_written();
  return facts;
}

}  // namespace orbweave
