// The facts of a run that a report holds.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/hole_facts.h"
#include "io/job/job.h"
#include "io/mesh_facts.h"

namespace orbweave {

/// A stage that a job is still to run.
struct ExpectedStage {
  std::string name;
  double seconds = 0.0;  ///< that it typically takes
};

/// One stage's measurements: bytes and calls of the counter by all processes together, the rest by
/// the root.
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
  /// CPU time of each of these chunks on the thread that the chunk began on. A job of one thread
  /// has no other.
  std::vector<double> chunk_cpu_seconds = {};
  /// Of the common counter that chunks are dealt by; 0: by one process.
  std::uint64_t counter_calls = 0;
};

/// What a run takes, as predicted before it or as measured.
struct ResourceFacts {
  std::uint64_t peak_memory_bytes = 0;
  std::uint64_t disk_bytes = 0;  ///< most that work directory and output hold at one time
  double seconds = 0.0;          ///< 0: unknown
};

/// A part of space, and how many patches of the propagation are contested there.
struct ContestedFacts {
  Vec3 center;
  std::uint64_t patches = 0;
};

/// A part of the surface whose side is a guess as a whole.
struct DoubtfulFacts {
  Vec3 center;
  double area = 0.0;   ///< share of the surface
  std::string reason;  ///< what makes the side a guess
};

/// Where the normals of a run come from.
struct NormalFacts {
  NormalSource source = NormalSource::kAuto;     ///< kAuto: not known yet
  Orientation orientation = Orientation::kAuto;  ///< what decided the side; kAuto: the file's side
  std::uint64_t neighbors = 0;                   ///< that a normal was estimated from
  double max_radius = 0.0;                       ///< no neighbour was farther away; world units
  std::uint64_t patches = 0;                     ///< of the propagation
  std::uint64_t components = 0;                  ///< of the patches, that no vote connects
  std::uint64_t contested = 0;  ///< patches whose votes for their sign are not 3 to 1
  double satisfied = 1.0;       ///< share of all votes that agree with the result
  std::vector<ContestedFacts> contested_places;  ///< with the most of them, at most three
  std::uint64_t ground_patches = 0;              ///< that belong to the ground, where that is asked
  std::uint64_t ground_patches_down = 0;         ///< of them, those that face down all the same
  std::uint64_t interiors = 0;                   ///< components that were seen from their inside
  double contested_area = 0.0;                   ///< share of the surface on contested patches
  double doubtful_area = 0.0;                    ///< share of it whose side as a whole is a guess
  std::vector<DoubtfulFacts> doubtful;           ///< the largest of these parts, at most three
};

/// What the cleaning did, or would have done.
struct CleaningFacts {
  double thickness = 0.0;          ///< of the scanned layers; world units; 0: not measured
  double spacing = 0.0;            ///< of the raw points
  CleaningOptions options;         ///< what was applied
  std::string reason;              ///< noise, and what was done about it or would have been
  std::uint64_t points_moved = 0;  ///< by smoothing, of those that thinning left
  double mean_move = 0.0;          ///< of the points moved, over all passes; world units
  /// The radius of the smoothing and the spacing of the thinning follow the noise place by place.
  bool is_local = false;
  double least_radius = 0.0;     ///< of the smoothing where anything is moved; world units
  double most_radius = 0.0;      ///< likewise; before the places are measured, an upper bound
  double untouched_share = 0.0;  ///< of the places, where layers are thin and nothing is moved
};

/// What tells a run that an input is still the file that its results were made from.
struct TrustedFile {
  std::string file;
  std::uint64_t bytes = 0;
  std::string modified;            ///< time of its last change, UTC
  std::uint64_t bytes_hashed = 0;  ///< of its content; a change of the others goes unnoticed where
                                   ///< size and time stay as they are
};

struct RunReport {
  std::string version;
  std::vector<std::string> command;
  Job options;                     ///< resolved
  std::vector<std::string> files;  ///< after globbing
  std::vector<TrustedFile> trusted;
  std::uint64_t points_read = 0;
  std::map<std::string, std::uint64_t> points_dropped;  ///< by reason
  std::uint64_t points_unused = 0;                      ///< kept, but no triangle uses them
  std::uint64_t pieces_removed = 0;                     ///< smaller than fill.min_triangles
  std::uint64_t triangles_removed = 0;                  ///< of them
  CleaningFacts cleaning;
  NormalFacts normals;
  std::string coordinate_system;        ///< of the input, where it says; written beside the mesh
  std::optional<Vec3> meters_per_unit;  ///< of x, y and z, as the input says
  Vec3 origin;  ///< that the mesh file's coordinates are counted from; world units
  Box bounds;
  std::uint64_t chunks = 0;
  double halo_width = 0.0;
  std::uint64_t largest_chunk_points = 0;
  std::vector<double> radii;
  std::string radii_reason;
  std::uint64_t conflicts_lost = 0;
  std::optional<VoronoiFacts> voronoi;  ///< of cocone and tight_cocone
  MeshFacts mesh;
  std::vector<HoleFacts> holes;  ///< every boundary loop before the fill, in canonical order
  std::vector<StageFacts> stages;
  std::uint64_t peak_memory_bytes = 0;
  ResourceFacts predicted;  ///< from the counting pass
  ResourceFacts measured;
  int ranks = 1;  ///< processes that worked on it
  /// An earlier run had written all outputs and left its work directory, which it was to keep or
  /// had no time to remove. It is removed now; nothing else is told then.
  bool ended_before = false;
  std::vector<std::string> notes;     ///< all that the run said, warnings too
  std::vector<std::string> warnings;  ///< of them
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
  Vec3 origin;  ///< that the mesh file's coordinates are counted from; world units
  double seconds = 0.0;
};

}  // namespace orbweave
