// The system calls that write, flush and rename files, in one table, so that tests can make any
// one of them fail (tests/faults). `.ci/check_file_calls` keeps other code from calling them past
// the table.
#pragma once

#include <fcntl.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>

namespace orbweave {

/// Each entry has the signature, the result and the errno of the call it is named after.
struct FileCalls {
  ssize_t (*write)(int, const void*, std::size_t) = ::write;
  ssize_t (*pwrite)(int, const void*, std::size_t, off_t) = ::pwrite;
  ssize_t (*pwritev)(int, const iovec*, int, off_t) = ::pwritev;
  int (*ftruncate)(int, off_t) = ::ftruncate;
  int (*fsync)(int) = ::fsync;
  int (*fdatasync)(int) = ::fdatasync;
#ifdef __linux__
  int (*fallocate)(int, int, off_t, off_t) = ::fallocate;
  int (*syncfs)(int) = ::syncfs;
  int (*renameat2)(int, const char*, int, const char*, unsigned) = ::renameat2;
#endif
  int (*rename)(const char*, const char*) = ::rename;
};

/// Only a test's main() assigns to the table, before any other thread runs. A call costs one load
/// more than a direct one, beside the microsecond that the system takes.
inline constinit FileCalls file_calls;

/// A store that was made anew flushes nothing for so long: a power cut could only take what is
/// computed again in that time. Only a test's main() assigns to it.
inline constinit std::chrono::seconds time_unflushed{10};

}  // namespace orbweave
