// gzip-compressed streams, decompressed on the way.
#pragma once

#include <memory>

#include "io/streams/byte_source.h"

namespace orbweave {

/// Decompresses gzip data (one or several members, one after another) in bounded memory. Its
/// read() throws Error (bad input) for data that is no gzip, is damaged (checksum, length) or
/// ends early; the place is the byte of the compressed file.
std::unique_ptr<ByteSource> gunzip_byte_source(std::unique_ptr<ByteSource> compressed);

}  // namespace orbweave
