// Which of many things that follow one another closely lie near some places.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/holes/patch/box_tree.h"

namespace orbweave {

/// Numbers below `count` whose boxes meet one of the places, ascending. box_of(number) is called
/// from several threads. Fast where things that follow one another lie close together. Runs on the
/// calling TBB arena.
std::vector<std::uint32_t> numbers_near(std::uint32_t count, const BoxTree& places,
                                        const std::function<Box(std::uint32_t)>& box_of);

}  // namespace orbweave
