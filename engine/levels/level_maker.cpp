#include "engine/levels/level_maker.h"

#include <algorithm>
#include <string>
#include <utility>

#include "engine/levels/simplify.h"
#include "engine/validation/usable_scale.h"
#include "io/bounds.h"
#include "io/error.h"
#include "io/hex_digits.h"
#include "io/system/running_checksum.h"
#include "partition/canonical_order.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatch = std::size_t{1} << 16;

void read_vertices(MeshStream& mesh, VertexTable& table, const StopToken& stop) {
  for (PointCloud batch; mesh.read_vertices(batch, kBatch);) {
    stop.check();
    table.append(batch);
  }
}

/// The corners of triangles, each once, with their positions.
class CornerPositions {
 public:
  CornerPositions(const VertexTable& table, std::span<const Triangle64> triangles) {
    for (const Triangle64& t : triangles) numbers_.insert(numbers_.end(), t.begin(), t.end());
    std::sort(numbers_.begin(), numbers_.end());
    numbers_.erase(std::unique(numbers_.begin(), numbers_.end()), numbers_.end());
    const std::vector<std::byte> rows = table.rows(numbers_);
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      positions_.push_back(position_of_row(rows.data() + i * table.row_bytes()));
  }
  Vec3 of(std::uint64_t number) const {
    const auto at = std::lower_bound(numbers_.begin(), numbers_.end(), number);
    return positions_[static_cast<std::size_t>(at - numbers_.begin())];
  }

 private:
  std::vector<std::uint64_t> numbers_;
  std::vector<Vec3> positions_;
};

std::uint64_t code_of(const Triangle64& t, const CornerPositions& corners,
                      const MortonFrame& frame) {
  const Vec3 a = corners.of(t[0]);
  const Vec3 b = corners.of(t[1]);
  const Vec3 c = corners.of(t[2]);
  if (!is_finite(a) || !is_finite(b) || !is_finite(c))
    throw_bad_input("a triangle has a coordinate that is not finite",
                    {.found = "a corner at vertex " + std::to_string(t[0]) + ", " +
                              std::to_string(t[1]) + " or " + std::to_string(t[2]),
                     .advice = "'orbweave fill MESH -o OUT.ply' leaves such triangles out"});
  return frame.code(a + (1.0 / 3.0) * ((b - a) + (c - a)));
}

}  // namespace

LevelMaker::StoredMesh LevelMaker::stored_mesh(MeshStream& mesh, const PointSchema& schema,
                                               const LevelOptions& options,
                                               const LevelEvents& events, const StopToken& stop) {
  level_workers(options);  // a budget that is too small is refused before the work
  StoredMesh stored;
  stored.vertices = std::make_unique<VertexTable>(options.directory, schema);
  read_vertices(mesh, *stored.vertices, stop);
  const Box bounds = stored.vertices->bounds();
  require_usable_scale({}, "mesh", bounds);
  const MortonFrame frame(root_cube(bounds.empty() ? Box{{}, {}} : bounds));
  constexpr std::uint64_t kShareOfRun = 6;  // the sort has its vector twice while that grows
  TriangleSorter sorter(options.directory, options.memory_bytes / kShareOfRun);
  RunningChecksum checksum;
  ListedHoles holes;
  for (std::vector<Triangle64> batch; mesh.read_triangles(batch, kBatch);) {
    stop.check();
    checksum.add(batch.data(), batch.size() * sizeof(Triangle64));
    const CornerPositions corners(*stored.vertices, batch);
    const std::span<const FacePatch> patches =
        options.keeps_tags ? mesh.patches() : std::span<const FacePatch>();
    checksum.add(patches.data(), patches.size_bytes());
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const Triangle64& t = batch[i];
      const FacePatch patch = patches.empty() ? FacePatch{} : patches[i];
      sorter.add({code_of(t, corners, frame), t, patch});
      if (!patches.empty())
        holes.add(patch, {corners.of(t[0]), corners.of(t[1]), corners.of(t[2])});
    }
    if (events.read) events.read(batch.size());
  }
  stored.triangles = std::make_unique<SortedTriangles>(sorter.finish(stop));
  stored.checksum = checksum.value();
  stored.holes = holes.largest();
  stored.hole_count = holes.count();
  if (stored.triangles->size() == 0) throw_bad_input("the mesh has no triangle");
  return stored;
}

LevelMaker::LevelMaker(MeshStream& mesh, const PointSchema& schema, const LevelOptions& options,
                       const LevelEvents& events, const StopToken& stop)
    : options_(options),
      events_(events),
      stop_(stop),
      mesh_(stored_mesh(mesh, schema, options, events, stop)),
      own_nodes_(options.nodes ? nullptr : std::make_unique<SpooledNodes>(options.directory)),
      nodes_(options.nodes ? options.nodes : own_nodes_.get()),
      row_bytes_(mesh_.vertices->row_bytes()) {
  levels_.nodes = level_tree(*mesh_.triangles, options.leaf_triangles);
  levels_.facts.resize(levels_.nodes.size());
  levels_.triangles = mesh_.triangles->size();
  levels_.vertices = mesh_.vertices->size();
  states_.resize(levels_.nodes.size(), State::kAbsent);
  begin_nodes();
  if (options.keeps_tags) find_components();
}

/// What is in the key decides the octree and every node. The content of the mesh stands for all
/// that made it.
void LevelMaker::begin_nodes() {
  constexpr const char* kLayout = "2";  // to be raised when nodes become others
  NodePlan plan;
  plan.key = std::string("layout of levels = ") + kLayout +
             "\nleaf triangles = " + std::to_string(options_.leaf_triangles) +
             "\nbytes of a vertex = " + std::to_string(row_bytes_) +
             "\nfaces have tags = " + (options_.keeps_tags ? "yes" : "no") +
             "\nvertices = " + std::to_string(levels_.vertices) + ", " +
             hex_digits(mesh_.vertices->checksum()) +
             "\ntriangles = " + std::to_string(levels_.triangles) + ", " +
             hex_digits(mesh_.checksum) + "\n";
  plan.nodes = static_cast<std::uint32_t>(levels_.nodes.size());
  plan.row_bytes = row_bytes_;
  nodes_->begin(plan);
}

/// Components are those of the mesh, so all leaves are looked at before the first tile.
void LevelMaker::find_components() {
  parts_.resize(levels_.nodes.size());
  std::uint32_t parts = 0;
  for (std::uint32_t number = 0; number < levels_.nodes.size(); ++number) {
    const LevelNode& node = levels_.nodes[number];
    if (!node.is_leaf()) continue;
    stop_.check();
    const NodeMesh mesh = bare_leaf(mesh_.triangles->read(node.first, node.triangles));
    components_.add(mesh.triangles, [&](std::uint32_t vertex) { return mesh.vertices[vertex]; });
    parts_[number] = parts++;
  }
  components_.finish();
}

void LevelMaker::on_threads(std::size_t count, const std::function<void(std::size_t)>& work) const {
  // A loop of TBB would be cancelled by the first failure, and with it, without a word, every loop
  // within the nodes in the making: what these had not come to would be missing in stored nodes.
  std::vector<ChunkTask> tasks;
  for (std::size_t i = 0; i < count; ++i) tasks.push_back({static_cast<ChunkId>(i), 0, 1});
  run_chunks(tasks, {.threads = level_workers(options_)}, work);
}

bool LevelMaker::children_serve(std::uint32_t number) const {
  return std::ranges::all_of(levels_.nodes[number].children,
                             [&](std::uint32_t child) { return states_[child] == State::kServes; });
}

void LevelMaker::make(const Serves& serves) {
  if (events_.planned) events_.planned(static_cast<std::uint32_t>(levels_.nodes.size()), bounds());
  for (const std::vector<std::uint32_t>& nodes : nodes_by_height(levels_.nodes)) {
    on_threads(nodes.size(), [&](std::size_t i) {
      if (children_serve(nodes[i])) make_node(nodes[i], serves);
    });
    if (levels_.nodes[nodes.front()].is_leaf()) keep_seams();
  }
}

void LevelMaker::make() {
  make([](const LevelNode&, const LevelFacts&) { return true; });
}

void LevelMaker::make_node(std::uint32_t number, const Serves& serves) {
  stop_.check();
  const LevelNode& node = levels_.nodes[number];
  const bool is_there = !node.is_leaf() && nodes_->has(number);
  NodeMesh mesh;
  if (!is_there) {
    mesh = made_node(number);
  } else {
    levels_.facts[number] = nodes_->facts(number);
    if (events_.done) mesh = nodes_->mesh(number);
    const std::scoped_lock lock(mutex_);
    ++levels_.reused;
  }
  states_[number] =
      node.is_leaf() || serves(node, levels_.facts[number]) ? State::kServes : State::kMade;
  if (events_.done) events_.done(number, points(mesh), mesh);
}

NodeMesh LevelMaker::made_node(std::uint32_t number) {
  const bool is_leaf = levels_.nodes[number].is_leaf();
  LevelFacts& facts = levels_.facts[number];
  NodeMesh mesh = is_leaf ? leaf(number) : simplified(number);
  facts.vertices = mesh.vertices.size();
  facts.triangles = mesh.triangles.size();
  const std::vector<OpenEdge> open = open_edges(mesh);
  facts.border_triangles = triangles_at(open);
  if (is_leaf) {
    facts.bounds = bounds_of(positions(mesh));
    add_seams(mesh, open);
  } else {
    nodes_->keep(number, facts, mesh);
  }
  return mesh;
}

void LevelMaker::add_seams(const NodeMesh& mesh, std::span<const OpenEdge> open) {
  const std::scoped_lock lock(mutex_);
  for (const OpenEdge& edge : open) seams_.push_back(mesh_edge(mesh, edge));
}

/// Open edges of two leaves lie between them; those of one leaf are rims of the mesh.
void LevelMaker::keep_seams() {
  std::sort(seams_.begin(), seams_.end());
  std::vector<MeshEdge> twice;
  for (std::size_t i = 1; i < seams_.size(); ++i)
    if (seams_[i] == seams_[i - 1] && (twice.empty() || twice.back() != seams_[i]))
      twice.push_back(seams_[i]);
  seams_ = std::move(twice);
}

std::vector<std::uint32_t> LevelMaker::cut() const {
  std::vector<std::uint32_t> nodes;
  std::vector<std::uint32_t> left = {0};
  while (!left.empty()) {
    const std::uint32_t number = left.back();
    left.pop_back();
    const std::vector<std::uint32_t>& children = levels_.nodes[number].children;
    if (states_[number] == State::kServes)
      nodes.push_back(number);
    else
      left.insert(left.end(), children.rbegin(), children.rend());
  }
  return nodes;
}

std::vector<std::uint32_t> LevelMaker::border_vertices(const NodeMesh& mesh) const {
  std::vector<std::uint32_t> vertices;
  for (const OpenEdge& edge : open_edges(mesh)) {
    if (!std::binary_search(seams_.begin(), seams_.end(), mesh_edge(mesh, edge))) continue;
    vertices.push_back(edge.low);
    vertices.push_back(edge.high);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

NodeMesh LevelMaker::leaf(std::uint32_t number) const {
  const LevelNode& node = levels_.nodes[number];
  NodeMesh mesh = leaf_mesh(*mesh_.vertices, mesh_.triangles->read(node.first, node.triangles));
  if (!options_.keeps_tags) mesh.tags.clear();
  if (components().size() > 1) {
    const std::vector<std::uint32_t> ranks = components_.ranks(parts_[number], mesh.triangles);
    for (std::size_t t = 0; t < ranks.size(); ++t) mesh.tags[t].component = ranks[t];
  }
  return mesh;
}

NodeMesh LevelMaker::node(std::uint32_t number) const {
  return levels_.nodes[number].is_leaf() ? leaf(number) : nodes_->mesh(number);
}

NodeMesh LevelMaker::merged_children(std::uint32_t number) const {
  std::vector<NodeMesh> parts;
  for (const std::uint32_t child : levels_.nodes[number].children) parts.push_back(node(child));
  return merged_mesh(parts, row_bytes_);
}

NodeMesh LevelMaker::simplified(std::uint32_t number) {
  LevelFacts& facts = levels_.facts[number];
  for (const std::uint32_t child : levels_.nodes[number].children) {
    facts.bounds.extend(levels_.facts[child].bounds);
    facts.error = std::max(facts.error, levels_.facts[child].error);
    facts.is_sound = facts.is_sound && levels_.facts[child].is_sound;
  }
  const NodeMesh merged = merged_children(number);
  const std::vector<std::uint32_t> locked = border_vertices(merged);
  // Where the border alone takes most of the triangles, the inside would be torn down for it.
  constexpr std::size_t kTrianglesOfBorderVertex = 3;
  const std::size_t target =
      std::max(std::min<std::size_t>(options_.leaf_triangles, merged.triangles.size() / 2),
               kTrianglesOfBorderVertex * locked.size());
  Simplification simpler =
      simplify_between(positions(merged), merged.triangles, locked, {.triangles = target});
  facts.error += simpler.error;
  facts.is_sound = facts.is_sound && simpler.is_sound;
  std::vector<FaceTag> tags =
      simplified_tags(positions(merged), merged.triangles, merged.tags, simpler.triangles);
  NodeMesh mesh = used_part(merged, std::move(simpler.triangles), row_bytes_);
  mesh.tags = std::move(tags);
  return mesh;
}

Levels make_levels(MeshStream& mesh, const LevelOptions& options, const LevelEvents& events,
                   const StopToken& stop) {
  LevelMaker maker(mesh, mesh.schema(), options, events, stop);
  maker.make();
  return maker.levels();
}

}  // namespace orbweave
