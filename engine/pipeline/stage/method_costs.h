// What the reconstruction methods cost that work on the whole cloud at once.
#pragma once

#include <cstdint>
#include <string>

#include "engine/pipeline/stage/partition.h"
#include "io/job/job.h"

namespace orbweave {

/// Measured on the 100,250-point dragon (docs/study.md), with a margin.
struct MethodCosts {
  std::uint64_t bytes_per_point = 0;
  double microseconds_per_point = 0.0;  ///< of one thread
  double vertices_per_point = 1.0;      ///< of the surface
};

/// Zeros for ball pivoting, whose costs are those of its stage.
MethodCosts costs_of(ReconstructionMethod method);

/// What normals cost that are the directions to poles; zeros for other sources of normals.
MethodCosts costs_of(NormalSource source);

/// More points than a method takes that holds the whole cloud: chunks of that size are one chunk.
inline constexpr std::uint64_t kOneChunkPoints = std::uint64_t{1} << 32;

/// Whether the method is one of the Voronoi family, which have no ball radii and take the whole
/// cloud in one chunk where goes_in_chunks does not say otherwise.
inline bool is_in_core(ReconstructionMethod method) {
  return method != ReconstructionMethod::kBallPivoting;
}

/// Whether the method is Cocone or goes by its name where the cloud goes in chunks.
inline bool is_cocone(ReconstructionMethod method) {
  return method == ReconstructionMethod::kCocone || method == ReconstructionMethod::kSuperCocone;
}

/// Whether the method finds out where points are sampled too sparsely.
inline bool tells_undersampling(ReconstructionMethod method) {
  return is_cocone(method) || method == ReconstructionMethod::kTightCocone;
}

/// Whether so many points go through Super Cocone: where the job asks for it, or for a Cocone that
/// does not fit the memory budget.
bool goes_in_chunks(const Job& job, std::uint64_t points);

/// Whether the points of the job were cut for Super Cocone; a single chunk goes as a whole.
bool is_super_cocone(const Job& job, const Partition& partition);

/// How far beyond a chunk Super Cocone looks, in sides of the chunk's cube: at first, and where
/// that does not do.
inline constexpr double kCoconeHalo = 0.125;
inline constexpr double kGrownCoconeHalo = 0.25;

/// Points of a surface in a chunk's grown box, and in both of its boxes together, over its own.
inline constexpr double kGrownCoconeBox =
    (1.0 + 2.0 * kGrownCoconeHalo) * (1.0 + 2.0 * kGrownCoconeHalo);
inline constexpr double kCoconeBoxesPerChunk =
    (1.0 + 2.0 * kCoconeHalo) * (1.0 + 2.0 * kCoconeHalo) + kGrownCoconeBox;

/// Most points of a chunk of Super Cocone: as many as fit the budget with those around them, or
/// as the job says. Throws Error (resource) where that is too few to be worth while.
std::uint64_t super_cocone_chunk_points(const Job& job);

/// Whether the vertices of the method's surface are not the points.
inline bool has_own_vertices(ReconstructionMethod method) {
  return method == ReconstructionMethod::kPowerCrust;
}

/// The name of the job's method, as job files have it.
std::string method_name(const Job& job);

/// Throws Error (resource) where the method takes more than the job's budget for so many points,
/// and says how much it takes.
void require_memory_for_method(const Job& job, std::uint64_t points);

/// The same for normals that are the directions to poles: a Voronoi cell is certain where all balls
/// around its corners are, and such a ball may reach across the whole cloud.
void require_memory_for_poles(const Job& job, std::uint64_t points);

}  // namespace orbweave
