#include "tests/io/stored_arrays.h"

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>

namespace orbweave::test {

std::vector<ArrayView> Arrays::views() const {
  return {{"values", ScalarType::kFloat64, 3, values.size() / 3, values.data()},
          {"bytes", ScalarType::kUint8, 5, bytes.size() / 5, bytes.data()},
          {"nothing", ScalarType::kInt32, 2, 0, nullptr}};
}

Arrays make_arrays(std::size_t rows, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Arrays arrays;
  for (std::size_t i = 0; i < rows * 3; ++i)
    arrays.values.push_back(static_cast<double>(random() >> 11));
  for (std::size_t i = 0; i < rows * 5; ++i)
    arrays.bytes.push_back(static_cast<std::uint8_t>(random()));
  return arrays;
}

bool same(const StoredResult& stored, const Arrays& arrays) {
  return stored.read_all<double>("values") == arrays.values &&
         stored.read_all<std::uint8_t>("bytes") == arrays.bytes && stored.rows("nothing") == 0;
}

void put(const std::filesystem::path& path, std::size_t at, int byte) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte));
}

ErrorKind status_of(const std::function<void()>& action, std::string* message) {
  try {
    action();
  } catch (const Error& error) {
    if (message != nullptr) *message = error.what();
    return error.kind();
  }
  return ErrorKind::kNone;
}

int count_files(const std::filesystem::path& directory, const std::string& ending) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory))
    count += entry.path().filename().string().ends_with(ending);
  return count;
}

bool succeeds_in_child(const std::function<bool()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    bool good = false;
    try {
      good = action();
    } catch (...) {
    }
    _exit(good ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace orbweave::test
