// How the files of a job's mesh are written.
#pragma once

#include <span>
#include <vector>

#include "io/hole_facts.h"
#include "io/job/job.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/patch_confidence.h"

namespace orbweave {

/// The confidence of each hole's patch, by id from 1 on.
inline std::vector<float> confidence_of_patches(std::span<const HoleFacts> holes) {
  std::vector<float> confidence;
  confidence.reserve(holes.size());
  for (const HoleFacts& hole : holes)
    note_confidence(confidence, hole.id, static_cast<float>(hole.confidence));
  return confidence;
}

inline MeshWriterOptions writer_options(const OutputOptions& output,
                                        std::span<const HoleFacts> holes, Vec3 origin = {}) {
  MeshWriterOptions options;
  options.origin = origin;
  options.binary = output.binary;
  options.float_positions = output.float_positions;
  options.has_confidence = output.confidence;
  if (output.confidence) options.confidence = confidence_of_patches(holes);
  return options;
}

}  // namespace orbweave
