// How long the process has worked.
#pragma once

namespace orbweave {

/// Seconds of a clock that only goes forward, from some fixed moment.
double steady_seconds();

/// Seconds that all threads of the process have worked so far, in the program and in the system.
double process_cpu_seconds();

/// Seconds that the calling thread has worked so far.
double thread_cpu_seconds();

}  // namespace orbweave
