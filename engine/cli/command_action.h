// What a command does once it was asked for.
#pragma once

#include <functional>

namespace orbweave {

/// Throws Error.
using CommandAction = std::function<void()>;

}  // namespace orbweave
