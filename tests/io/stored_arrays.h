// Results for tests of the chunk store, and the means to damage them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/store/chunk_store.h"

namespace orbweave::test {

struct Arrays {
  std::vector<double> values;       ///< rows of 3
  std::vector<std::uint8_t> bytes;  ///< rows of 5
  std::vector<ArrayView> views() const;
};

/// Random, the same for the same seed.
Arrays make_arrays(std::size_t rows, std::uint64_t seed);
bool same(const StoredResult& stored, const Arrays& arrays);

/// Overwrites one byte in place.
void put(const std::filesystem::path& path, std::size_t at, int byte);

/// How the action ends, and with what message.
ErrorKind status_of(const std::function<void()>& action, std::string* message = nullptr);

/// Files that end like this, anywhere below.
int count_files(const std::filesystem::path& directory, const std::string& ending);

/// Runs `action` in a child process; true when it ends with status 0.
bool succeeds_in_child(const std::function<bool()>& action);

}  // namespace orbweave::test
