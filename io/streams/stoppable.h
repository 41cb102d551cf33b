// Bytes that a request to stop ends, whatever a reader looks for in them.
#pragma once

#include <memory>

#include "io/stop_token.h"
#include "io/streams/byte_source.h"
#include "io/streams/random_access.h"

namespace orbweave {

/// The same bytes: reads throw Error (interrupted) where `stop`, which outlives them, asks for it.
/// The object itself where `stop` is null.
std::unique_ptr<ByteSource> stoppable(std::unique_ptr<ByteSource> source, const StopToken* stop);
std::unique_ptr<RandomAccess> stoppable(std::unique_ptr<RandomAccess> file, const StopToken* stop);

}  // namespace orbweave
