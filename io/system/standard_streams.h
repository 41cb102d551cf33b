// Standard input, output and error of a program that was started without them.
#pragma once

namespace orbweave {

/// Keeps the numbers of closed standard streams from files that are opened later: what is meant for
/// a stream would be written into such a file. Reading or writing a closed stream still fails. To
/// be called before any file is opened.
void hold_closed_streams();

}  // namespace orbweave
