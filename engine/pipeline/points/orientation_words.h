// What a run says about the orientation of estimated normals: its report, its line, its warnings.
#pragma once

#include <string>

#include "engine/normals/orientation.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/report/report_facts.h"

namespace orbweave {

/// What the report says of a propagation.
void take_facts(const PatchOrientation& orientation, NormalFacts& normals);

/// What decided the side of the normals, and how surely.
std::string describe_orientation(const NormalFacts& normals);

/// The same with how the normals were estimated.
std::string describe_normals(const NormalFacts& normals);

/// Warns where votes contradict each other in more than a small part of the cloud, and where the
/// side of more than a small part of the surface is a guess as a whole.
void warn_of_orientation(StageRunner& runner, const NormalFacts& normals);

}  // namespace orbweave
