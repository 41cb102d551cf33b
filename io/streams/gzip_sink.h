// gzip compression on the way to a file.
#pragma once

#include <memory>

#include "io/streams/byte_sink.h"

namespace orbweave {

/// Compresses into one gzip member without name and time: same content, same bytes.
std::unique_ptr<ByteSink> gzip_byte_sink(std::unique_ptr<ByteSink> compressed);

}  // namespace orbweave
