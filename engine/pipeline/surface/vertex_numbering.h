// The numbers that a vertex has on its way from a scan to the mesh file.
//
// number     | counts                                                  | type          | made by
// -----------|---------------------------------------------------------|---------------|--------------
// input      | rows of the scans, in the order read                    | std::uint64_t |
// PointSource canonical  | points of the job, chunk by chunk in canonical order    | std::uint64_t
// | Partition local      | a chunk's own points, then the outer vertices that it   | LocalVertex |
// LocalNumbers
//            | uses                                                    |               |
// batch      | new vertices of a batch of patches, from kNewVertex on  | std::uint64_t | PatchBatch
// mesh       | new vertices of all batches, from kNewVertex on         | std::uint64_t |
// OutputNumbers copy       | copies of pinched vertices, over the whole mesh         | CopyIndex |
// SplitVertices output     | vertices of the mesh file: used points, new vertices,   | OutputVertex
// | OutputNumbers
//            | copies                                                  |               |
//
// Canonical numbers are what stages exchange. A canonical number and one of a new vertex share a
// word: new vertices begin at kNewVertex (engine/holes/hole_pass.h). Nothing that is stored depends
// on input numbers.
#pragma once

#include <cstdint>

namespace orbweave {

enum class LocalVertex : std::uint32_t {};
enum class CopyIndex : std::uint64_t {};
enum class OutputVertex : std::uint64_t {};

constexpr std::uint32_t value_of(LocalVertex vertex) { return static_cast<std::uint32_t>(vertex); }
constexpr std::uint64_t value_of(CopyIndex copy) { return static_cast<std::uint64_t>(copy); }
constexpr std::uint64_t value_of(OutputVertex vertex) { return static_cast<std::uint64_t>(vertex); }

}  // namespace orbweave
