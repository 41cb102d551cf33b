// How many edges a vertex of the sheet is away from a hole's rim.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The ring of each vertex about the rim, whose own vertices have ring 0; `most` + 1 beyond.
std::vector<std::uint32_t> rings_about(const HoleProblem& problem, std::uint32_t most);

}  // namespace orbweave
