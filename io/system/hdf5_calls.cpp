#include "io/system/hdf5_calls.h"

#include <hdf5.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <mutex>
#include <stdexcept>
#include <type_traits>

#include "io/error.h"
#include "io/system/hdf5_exit.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

static_assert(std::is_same_v<Hdf5Id, hid_t> && std::is_same_v<int, herr_t>);

/// The library's global state. A program that calls close_hdf5_at_exit() has it closed at exit, but
/// not when a file could not be closed (its disk is full, or it is damaged): then HDF5 would try
/// again, and again, and complain.
struct Library {
  Library() = default;
  ~Library() {
    if (is_closed_here && all_files_closed) H5close();
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  std::mutex mutex;
  bool all_files_closed = true;
  bool is_closed_here = false;
};

Library& library() {
  static Library library;
  return library;
}

/// HDF5 crashes where its own small allocations fail: it is not called with less than that to be
/// had.
void require_memory_for_hdf5() {
  constexpr std::size_t kRoom = std::size_t{4} << 20;
  const std::unique_ptr<std::byte[]> room(new std::byte[kRoom]);
  // What is not looked at need not be there: the compiler may leave it out.
  volatile std::byte* const seen = room.get();
  *seen = std::byte{0};
}

/// Makes the arrays and closes the file. False on failure.
bool fill_file(const std::filesystem::path& path, std::span<const Hdf5Array> arrays,
               std::vector<std::uint64_t>& offsets) {
  const Hdf5Calls calls;
  errno = 0;
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  H5Pset_file_locking(access.get(), false, true);
  const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation.get(), false);
  Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
  if (!file.valid()) return false;
  bool done = true;
  for (const Hdf5Array& array : arrays) {
    offsets.push_back(0);
    done = done && create_hdf5_array(file.get(), array.name, hdf5_type(array.type), array.shape,
                                     offsets.back());
  }
  const bool closed = file.close();
  if (!closed) note_unclosed_hdf5_file();
  return closed && done;
}

}  // namespace

struct Hdf5Calls::Held {
  explicit Held(std::mutex& mutex) : lock(mutex) {}
  std::unique_lock<std::mutex> lock;
  H5E_auto2_t handler = nullptr;
  void* handler_data = nullptr;
};

Hdf5Calls::Hdf5Calls() {
  require_memory_for_hdf5();
  held_ = std::make_unique<Held>(library().mutex);
  H5Eget_auto2(H5E_DEFAULT, &held_->handler, &held_->handler_data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Calls::~Hdf5Calls() { H5Eset_auto2(H5E_DEFAULT, held_->handler, held_->handler_data); }

void note_unclosed_hdf5_file() { library().all_files_closed = false; }

void close_hdf5_at_exit() {
  const std::scoped_lock lock(library().mutex);
  H5dont_atexit();
  library().is_closed_here = true;
}

Hdf5Id hdf5_type(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
      return H5T_NATIVE_INT8;
    case ScalarType::kUint8:
      return H5T_NATIVE_UINT8;
    case ScalarType::kInt16:
      return H5T_NATIVE_INT16;
    case ScalarType::kUint16:
      return H5T_NATIVE_UINT16;
    case ScalarType::kInt32:
      return H5T_NATIVE_INT32;
    case ScalarType::kUint32:
      return H5T_NATIVE_UINT32;
    case ScalarType::kInt64:
      return H5T_NATIVE_INT64;
    case ScalarType::kUint64:
      return H5T_NATIVE_UINT64;
    case ScalarType::kFloat32:
      return H5T_NATIVE_FLOAT;
    case ScalarType::kFloat64:
      return H5T_NATIVE_DOUBLE;
  }
  throw std::logic_error("HDF5: unknown scalar type");
}

bool has_hdf5_arrays(const std::filesystem::path& path, std::span<const std::string> names) {
  const Hdf5Calls calls;
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  return file.valid() && std::all_of(names.begin(), names.end(), [&](const std::string& name) {
           return H5Lexists(file.get(), name.c_str(), H5P_DEFAULT) > 0;
         });
}

bool create_hdf5_array(Hdf5Id file, const std::string& name, Hdf5Id type,
                       std::span<const std::uint64_t> extents, std::uint64_t& offset) {
  const std::vector<hsize_t> shape(extents.begin(), extents.end());
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                         H5Sclose);
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_layout(creation.get(), H5D_CONTIGUOUS);
  H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(creation.get(), false);
  const Hdf5Handle dataset(
      H5Dcreate2(file, name.c_str(), type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      H5Dclose);
  if (!dataset.valid()) return false;
  const haddr_t address = H5Dget_offset(dataset.get());
  const bool has_bytes =
      std::all_of(shape.begin(), shape.end(), [](hsize_t extent) { return extent > 0; });
  offset = has_bytes ? address : 0;
  return !has_bytes || address != HADDR_UNDEF;
}

std::vector<std::uint64_t> make_hdf5_file(const std::filesystem::path& path,
                                          const std::filesystem::path& name,
                                          std::span<const Hdf5Array> arrays) {
  std::vector<std::uint64_t> offsets;
  if (!fill_file(path, arrays, offsets))
    throw_resource("cannot write an HDF5 file",
                   {.file = name.string(), .advice = advice_on(errno)});
  return offsets;
}

}  // namespace orbweave
