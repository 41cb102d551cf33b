// The report of a run: facts with stable keys (JSON), and the same for reading (HTML).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/job.h"

namespace orbweave {

/// Facts of a mesh; also what `inspect --json` prints for one.
struct MeshFacts {
  std::uint64_t vertices = 0;  ///< vertices in the file
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;      ///< connected over shared edges
  std::uint64_t boundary_edges = 0;  ///< edges of one triangle
  std::uint64_t boundary_loops = 0;
  std::uint64_t nonmanifold_edges = 0;     ///< edges of more than two triangles
  std::uint64_t nonmanifold_vertices = 0;  ///< vertices with more than one fan
  std::uint64_t inconsistent_edges = 0;    ///< directed edges used twice
  std::uint64_t degenerate_triangles = 0;  ///< two equal vertices
  std::uint64_t duplicate_triangles = 0;
  std::uint64_t unreferenced_vertices = 0;
  std::int64_t euler_characteristic = 0;  ///< of the referenced vertices
  double area = 0.0;                      ///< square world units
  bool watertight = false;                ///< closed, manifold, consistently oriented
  std::string checksum;                   ///< of coordinates and oriented triangles only
  Box bounds;
};

/// One stage's measurements.
struct StageFacts {
  std::string name;
  double seconds = 0.0;
  double cpu_seconds = 0.0;
  std::uint64_t points = 0;
  std::uint64_t bytes_read = 0;
  std::uint64_t bytes_written = 0;
  std::uint64_t chunks = 0;
  std::uint64_t chunks_reused = 0;      ///< committed by an earlier run
  std::uint64_t peak_memory_bytes = 0;  ///< resident, as sampled while the stage ran
  /// Wall time of each chunk that this process computed, in the order they ended.
  std::vector<double> chunk_seconds = {};
};

/// What a run takes, as predicted before it or as measured.
struct ResourceFacts {
  std::uint64_t peak_memory_bytes = 0;
  std::uint64_t disk_bytes = 0;  ///< most that work directory and output hold at one time
  double seconds = 0.0;          ///< 0: unknown
};

/// A boundary loop of the stitched mesh and what became of it.
struct HoleFacts {
  std::int32_t id = 0;             ///< rank among all loops, from 1; the faces' `hole`
  std::uint64_t first_vertex = 0;  ///< smallest vertex of the loop, in the output's numbers
  std::uint64_t edges = 0;
  double perimeter = 0.0;             ///< world units
  double diameter = 0.0;              ///< of the ball around the loop's centre, world units
  Vec3 center;                        ///< mean of the loop's vertices
  std::vector<std::uint32_t> chunks;  ///< that the loop's vertices lie in, ascending
  bool filled = false;
  std::int32_t joined_to = 0;  ///< of an island: the hole whose patch it bounds as well; 0: none
  std::string method;          ///< "direct", "plane", "implicit"; empty where it stays open
  std::string reason;          ///< why it stays open, or why the simpler method did not do
  std::uint64_t sites = 0;     ///< of the interpolant
  std::uint64_t points_added = 0;
  std::uint64_t triangles_added = 0;
  double residual = 0.0;          ///< largest distance of a site from the interpolant
  double condition = 0.0;         ///< of the linear system, estimated; 0: none was solved
  double rim_dihedral_deg = 0.0;  ///< largest angle between a patch face and the face at the rim
  double seconds = 0.0;
};

/// Where the normals of a run come from.
struct NormalFacts {
  std::string source;            ///< "file" or "estimated"
  std::string orientation;       ///< "scanner", "viewpoint", "up", "propagate", "none"; empty
                                 ///< for the file's
  std::uint64_t neighbors = 0;   ///< that a normal was estimated from
  double max_radius = 0.0;       ///< no neighbour was farther away; world units
  std::uint64_t patches = 0;     ///< of the propagation
  std::uint64_t components = 0;  ///< of the patches, that no vote connects
  std::uint64_t contested = 0;   ///< patches whose votes for their sign are not 3 to 1
  double satisfied = 1.0;        ///< share of all votes that agree with the result
};

/// What the clean-up did, or would have done.
struct PrepareFacts {
  double thickness = 0.0;  ///< of the scanned layers; world units; 0: not measured
  double spacing = 0.0;    ///< of the raw points
  PrepareOptions options;  ///< what was applied
  std::string reason;      ///< why, where it was chosen; what would have been chosen
  std::uint64_t points_moved = 0;
  double mean_move = 0.0;  ///< of the points moved, over all passes; world units
};

struct RunReport {
  std::string version;
  std::vector<std::string> command;
  Job options;                     ///< resolved
  std::vector<std::string> files;  ///< after globbing
  std::uint64_t points_read = 0;
  std::map<std::string, std::uint64_t> points_dropped;  ///< by reason
  std::uint64_t points_unused = 0;                      ///< kept, but no triangle uses them
  PrepareFacts prepare;
  NormalFacts normals;
  std::string coordinate_system;  ///< of the input, where it says; written beside the mesh
  Box bounds;
  std::uint64_t chunks = 0;
  double halo_width = 0.0;
  std::uint64_t largest_chunk_points = 0;
  std::vector<double> radii;
  std::string radii_reason;
  std::uint64_t conflicts_lost = 0;
  MeshFacts mesh;
  std::vector<HoleFacts> holes;  ///< every boundary loop before the fill, in canonical order
  std::vector<StageFacts> stages;
  std::uint64_t peak_memory_bytes = 0;
  ResourceFacts predicted;  ///< from the counting pass
  ResourceFacts measured;
  int ranks = 1;  ///< processes that worked on it
  /// An earlier run had written all outputs and was killed while it removed its work directory;
  /// nothing else is told then.
  bool ended_before = false;
  std::vector<std::string> notes;
};

/// What `orbweave fill` did.
struct FillReport {
  std::string version;
  std::vector<std::string> command;
  Job options;                                             ///< resolved
  std::string file;                                        ///< the mesh that was read
  std::map<std::string, std::uint64_t> triangles_dropped;  ///< before anything else, by reason
  MeshFacts before;                                        ///< as read
  MeshFacts after;                                         ///< as written
  std::vector<HoleFacts> holes;                            ///< every boundary loop
  std::uint64_t pieces_removed = 0;                        ///< smaller than fill.min_triangles
  std::uint64_t triangles_removed = 0;                     ///< of them
  double seconds = 0.0;
};

/// JSON text with the stable keys of the interface.
std::string report_json(const RunReport& report);
std::string mesh_facts_json(const MeshFacts& facts);
/// A list, as the report has it: a line per hole. `method` and `reason` are null where empty.
std::string holes_json(std::span<const HoleFacts> holes);
/// `mesh` is the mesh as written, `mesh_before` as read, `holes` as in the report of a run.
std::string fill_report_json(const FillReport& report);
/// Writes PATH (JSON) and, beside it, the same as .html. Atomic.
void write_report(const std::filesystem::path& path, const RunReport& report);
/// Writes PATH (JSON). Atomic.
void write_fill_report(const std::filesystem::path& path, const FillReport& report);

/// Peak resident memory of this process, bytes.
std::uint64_t peak_memory_bytes();
std::uint64_t current_memory_bytes();

}  // namespace orbweave
