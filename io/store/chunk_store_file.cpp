#include "io/store/chunk_store_file.h"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>

#include "io/store/packed_blocks.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/hdf5_calls.h"
#include "io/system/owned_files.h"
#include "io/system/system_advice.h"
#include "io/system/work_directory_errors.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr const char* kChecksumSuffix = ".xxh3";
constexpr const char* kVersionName = "orbweave_layout";
constexpr const char* kIdentityName = "orbweave_identity";
/// Longer than any identity: store, stage, edition, chunk.
constexpr std::size_t kMostIdentityBytes = 1024;

using Handle = Hdf5Handle;

Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // The latest format checksums all of HDF5's own structures.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  // The store's own lock covers the directory; not every file system has per-file locks.
  H5Pset_file_locking(access.get(), false, true);
  return access;
}

std::uint64_t block_count(std::uint64_t rows) {
  return (rows + kRowsPerChecksum - 1) / kRowsPerChecksum;
}

/// Where the blocks of a packed array are. False where it is not as the store writes it.
bool find_blocks(hid_t dataset, StoredArray& array) {
  // Deflate has 258 bytes in two bits at best.
  constexpr std::uint64_t kMostExpansion = 1040;
  array.blocks.resize(block_count(array.rows));
  for (std::size_t block = 0; block < array.blocks.size(); ++block) {
    const std::array<hsize_t, 2> at = {block * kRowsPerChecksum, 0};
    unsigned skipped_filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    if (H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped_filters, &address, &bytes) < 0 ||
        address == HADDR_UNDEF || skipped_filters != 0 ||
        bytes > most_packed_bytes(array.block_bytes()) ||
        array.block_bytes() / kMostExpansion > bytes)
      return false;
    array.blocks[block] = {address, bytes};
  }
  return true;
}

// ---------------------------------------------------------------- writing

using PackedArray = std::vector<std::vector<std::byte>>;  ///< its blocks; none: it is not packed

/// Creates the dataset of a packed array and writes its blocks. False on failure.
bool write_packed(hid_t file, StoredArray& array, const PackedArray& packed) {
  const std::array<hsize_t, 2> shape = {array.rows, array.columns};
  const std::array<hsize_t, 2> chunk = {kRowsPerChecksum, array.columns};
  const Handle space(H5Screate_simple(2, shape.data(), nullptr), H5Sclose);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(creation.get(), 2, chunk.data());
  H5Pset_shuffle(creation.get());
  H5Pset_deflate(creation.get(), 1);
  H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER);
  H5Pset_obj_track_times(creation.get(), false);
  const Handle dataset(H5Dcreate2(file, array.name.c_str(), hdf5_type(array.type), space.get(),
                                  H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                       H5Dclose);
  bool done = dataset.valid();
  for (std::size_t block = 0; done && block < packed.size(); ++block) {
    const std::array<hsize_t, 2> at = {block * kRowsPerChecksum, 0};
    done = H5Dwrite_chunk(dataset.get(), H5P_DEFAULT, 0, at.data(), packed[block].size(),
                          packed[block].data()) >= 0;
  }
  return done && find_blocks(dataset.get(), array);
}

bool write_version(hid_t file) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(
      H5Acreate2(file, kVersionName, H5T_NATIVE_INT, space.get(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  const int version = ChunkStore::kLayoutVersion;
  return attribute.valid() && H5Awrite(attribute.get(), H5T_NATIVE_INT, &version) >= 0;
}

bool write_identity(hid_t file, const ResultIdentity& identity) {
  const std::string text = identity.text();
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  if (H5Tset_size(type.get(), text.size()) < 0) return false;
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(
      H5Acreate2(file, kIdentityName, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.valid() && H5Awrite(attribute.get(), type.get(), text.data()) >= 0;
}

/// Writes everything but the arrays' bytes, and notes where these belong. False on failure.
bool lay_out(const std::filesystem::path& path, ResultIndex& index,
             std::span<const PackedArray> packed, const ResultIdentity& identity) {
  const Hdf5Calls calls;
  errno = 0;
  const Handle access = file_access();
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_link_phase_change(creation.get(), 64, 32);
  H5Pset_obj_track_times(creation.get(), false);
  Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
  bool done = file.valid() && write_version(file.get()) && write_identity(file.get(), identity);
  for (std::size_t i = 0; i < index.arrays.size(); ++i) {
    StoredArray& array = index.arrays[i];
    const std::array<std::uint64_t, 2> shape = {array.rows, array.columns};
    const std::array<std::uint64_t, 1> blocks = {block_count(array.rows)};
    done = done &&
           (packed[i].empty() ? create_hdf5_array(file.get(), array.name, hdf5_type(array.type),
                                                  shape, array.offset)
                              : write_packed(file.get(), array, packed[i])) &&
           create_hdf5_array(file.get(), array.name + kChecksumSuffix, H5T_NATIVE_UINT64, blocks,
                             array.checksum_offset);
  }
  if (!file.valid()) return false;
  const bool closed = file.close();
  if (!closed) note_unclosed_hdf5_file();
  return closed && done;
}

/// Throws Error (resource).
void write_rows(const std::filesystem::path& path, int file, const void* data, std::size_t bytes,
                std::uint64_t offset) {
  const std::span rows(static_cast<const std::byte*>(data), bytes);
  if (!write_at(file, offset, rows)) throw_write_error(path, errno);
}

/// Blocks whose checksums one thread takes.
constexpr std::size_t kGrain = 64;

StoredArray describe(const ArrayView& view, const ResultIdentity& identity) {
  StoredArray array;
  array.name = view.name;
  array.type = view.type;
  array.columns = view.columns;
  array.rows = view.rows;
  array.seed = seed_of_checksums(identity, view.name);
  const std::size_t row_bytes = array.row_bytes();
  const char* data = static_cast<const char*>(view.data);
  array.checksums.resize(block_count(view.rows));
  const auto sum_up = [&](std::size_t block) {
    const std::uint64_t first = block * kRowsPerChecksum;
    const std::uint64_t rows = std::min(kRowsPerChecksum, view.rows - first);
    array.checksums[block] =
        block_checksum(array, block, data + first * row_bytes, rows * row_bytes);
  };
  const std::size_t blocks = array.checksums.size();
  for_each_whole((blocks + kGrain - 1) / kGrain, [&](std::size_t part) {
    const std::size_t end = std::min(blocks, (part + 1) * kGrain);
    for (std::size_t b = part * kGrain; b < end; ++b) sum_up(b);
  });
  return array;
}

/// The blocks of an array that is worth it.
PackedArray pack(const ArrayView& view, const StoredArray& array) {
  PackedArray packed;
  if (array.rows < kRowsPerChecksum) return packed;
  const std::size_t whole = array.block_bytes();
  const std::span data(static_cast<const std::byte*>(view.data), array.rows * array.row_bytes());
  for (std::size_t first = 0; first < data.size(); first += whole) {
    const auto rows = data.subspan(first, std::min(whole, data.size() - first));
    packed.push_back(pack_block(rows, size_of(array.type), whole));
  }
  return packed;
}

std::uint64_t data_bytes(const StoredArray& array) {
  if (array.blocks.empty()) return array.rows * array.row_bytes();
  std::uint64_t bytes = 0;
  for (const StoredBlock& block : array.blocks) bytes += block.bytes;
  return bytes;
}

FileDescriptor write_all(const std::filesystem::path& path, std::span<const ArrayView> arrays,
                         ResultIndex& index, bool packed, const ResultIdentity& identity) {
  std::vector<PackedArray> blocks(arrays.size());
  for (std::size_t i = 0; packed && i < arrays.size(); ++i)
    blocks[i] = pack(arrays[i], index.arrays[i]);
  if (!lay_out(path, index, blocks, identity)) throw_write_error(path, errno);
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!file.valid()) throw_write_error(path, errno);
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const StoredArray& array = index.arrays[i];
    const std::size_t checksum_bytes = array.checksums.size() * sizeof(std::uint64_t);
    if (array.blocks.empty())
      write_rows(path, file.get(), arrays[i].data, data_bytes(array), array.offset);
    write_rows(path, file.get(), array.checksums.data(), checksum_bytes, array.checksum_offset);
    index.file_bytes += data_bytes(array) + checksum_bytes;
  }
  return file;
}

// ---------------------------------------------------------------- reading

struct Dataset {
  hid_t id;
  std::vector<hsize_t> shape;
  std::uint64_t offset = 0;
};

/// Calls use(dataset) with an open dataset of `rank` dimensions; false when there is none.
template <class Use>
bool with_dataset(hid_t file, const std::string& name, int rank, const Use& use) {
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.valid()) return false;
  const Handle space(H5Dget_space(dataset.get()), H5Sclose);
  if (!space.valid() || H5Sget_simple_extent_ndims(space.get()) != rank) return false;
  Dataset found{dataset.get(), std::vector<hsize_t>(static_cast<std::size_t>(rank)), 0};
  H5Sget_simple_extent_dims(space.get(), found.shape.data(), nullptr);
  const haddr_t address = H5Dget_offset(dataset.get());
  found.offset = address == HADDR_UNDEF ? 0 : address;
  return use(found);
}

/// The scalar type whose native form the dataset has; false when none.
bool scalar_type(hid_t dataset, ScalarType& type) {
  const Handle stored(H5Dget_type(dataset), H5Tclose);
  for (int t = 0; t <= static_cast<int>(ScalarType::kFloat64); ++t) {
    type = static_cast<ScalarType>(t);
    if (stored.valid() && H5Tequal(stored.get(), hdf5_type(type)) > 0) return true;
  }
  return false;
}

/// Whether the dataset lies in blocks of the store's size.
bool is_chunked(hid_t dataset, std::uint32_t columns) {
  const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  std::array<hsize_t, 2> chunk{};
  return creation.valid() && H5Pget_layout(creation.get()) == H5D_CHUNKED &&
         H5Pget_chunk(creation.get(), 2, chunk.data()) == 2 && chunk[0] == kRowsPerChecksum &&
         chunk[1] == columns;
}

/// Reads the description of one array; false when it is not as the store writes it, or has more
/// rows than a file of that size holds checksums of.
bool read_array(hid_t file, std::uint64_t file_bytes, StoredArray& array) {
  const bool data = with_dataset(file, array.name, 2, [&](const Dataset& dataset) {
    constexpr hsize_t kMostColumns = std::numeric_limits<std::uint32_t>::max();
    const std::uint64_t most_blocks = file_bytes / sizeof(std::uint64_t);
    if (dataset.shape[1] > kMostColumns || dataset.shape[0] / kRowsPerChecksum > most_blocks)
      return false;
    array.rows = dataset.shape[0];
    array.columns = static_cast<std::uint32_t>(dataset.shape[1]);
    array.offset = dataset.offset;
    return scalar_type(dataset.id, array.type) &&
           (!is_chunked(dataset.id, array.columns) || find_blocks(dataset.id, array));
  });
  return data && with_dataset(file, array.name + kChecksumSuffix, 1, [&](const Dataset& dataset) {
           if (dataset.shape[0] != block_count(array.rows)) return false;
           array.checksums.resize(dataset.shape[0]);
           array.checksum_offset = dataset.offset;
           return true;
         });
}

bool version_matches(hid_t file) {
  const Handle attribute(H5Aopen(file, kVersionName, H5P_DEFAULT), H5Aclose);
  int version = 0;
  return attribute.valid() && H5Aread(attribute.get(), H5T_NATIVE_INT, &version) >= 0 &&
         version == ChunkStore::kLayoutVersion;
}

/// Empty: the file has none.
std::optional<ResultIdentity> read_identity(hid_t file) {
  const Handle attribute(H5Aopen(file, kIdentityName, H5P_DEFAULT), H5Aclose);
  if (!attribute.valid()) return std::nullopt;
  const Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  const bool is_text = type.valid() && H5Tget_class(type.get()) == H5T_STRING &&
                       H5Tis_variable_str(type.get()) == 0 && space.valid() &&
                       H5Sget_simple_extent_npoints(space.get()) == 1;
  const std::size_t bytes = is_text ? H5Tget_size(type.get()) : 0;
  if (bytes == 0 || bytes > kMostIdentityBytes) return std::nullopt;
  std::string text(bytes, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return std::nullopt;
  return identity_from(text);
}

std::vector<std::string> array_names(hid_t file) {
  std::vector<std::string> names;
  H5G_info_t group{};
  if (H5Gget_info(file, &group) < 0) return names;
  for (hsize_t i = 0; i < group.nlinks; ++i) {
    std::array<char, 256> text{};
    if (H5Lget_name_by_idx(file, ".", H5_INDEX_NAME, H5_ITER_INC, i, text.data(), text.size(),
                           H5P_DEFAULT) <= 0)
      continue;
    const std::string name = text.data();
    if (!name.ends_with(kChecksumSuffix)) names.push_back(name);
  }
  return names;
}

/// Not valid where the file is damaged. Throws Error (resource) where the system refuses to open it
/// or to read it: then nothing is known of the file.
Handle open_result(const std::filesystem::path& path) {
  const Handle access = file_access();
  errno = 0;
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose);
  const int reason = file.valid() ? 0 : errno;
  if (is_lack(reason) || reason == EACCES || reason == EIO) throw_read_error(path, reason);
  return file;
}

/// Everything but the checksums themselves. Empty problem: all is well.
std::string read_layout(const std::filesystem::path& path, std::uint64_t file_bytes,
                        const ResultIdentity& identity, ResultIndex& index) {
  const Hdf5Calls calls;
  const auto damaged = [](std::string what) {
    note_unclosed_hdf5_file();
    return what;
  };
  const Handle file = open_result(path);
  if (!file.valid()) return damaged("a file that HDF5 cannot open");
  if (!version_matches(file.get())) return damaged("no result of this layout version");
  const std::optional<ResultIdentity> found = read_identity(file.get());
  if (!found) return damaged("a result that does not say where it belongs");
  if (*found != identity) return name_of_stranger(*found, identity);
  for (const std::string& name : array_names(file.get())) {
    StoredArray array;
    array.name = name;
    array.seed = seed_of_checksums(identity, name);
    if (!read_array(file.get(), file_bytes, array))
      return damaged("array '" + name + "' in an unknown form");
    index.arrays.push_back(std::move(array));
  }
  return {};
}

/// Whether so many rows are no more bytes than that.
bool fits(const StoredArray& array, std::uint64_t bytes) {
  return array.rows == 0 || array.row_bytes() <= bytes / array.rows;
}

bool lies_within(std::uint64_t offset, std::uint64_t bytes, std::uint64_t file_bytes) {
  return offset <= file_bytes && bytes <= file_bytes - offset;
}

}  // namespace

std::string result_name(ChunkId chunk) {
  std::array<char, 24> name{};
  std::snprintf(name.data(), name.size(), "%06u.h5", chunk);
  return name.data();
}

std::optional<ChunkId> chunk_of_result(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  ChunkId chunk = 0;
  std::from_chars(stem.data(), stem.data() + stem.size(), chunk);
  return file.filename() == result_name(chunk) ? std::optional(chunk) : std::nullopt;
}

void refuse_directory(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return;
  throw_stranger(path);
}

std::optional<ResultIdentity> identity_of_result(const std::filesystem::path& path) {
  const Hdf5Calls calls;
  const Handle file = open_result(path);
  if (!file.valid() || !version_matches(file.get())) return std::nullopt;
  return read_identity(file.get());
}

WrittenResult write_result_file(const std::filesystem::path& path,
                                std::span<const ArrayView> arrays, bool packed,
                                const ResultIdentity& identity) {
  const auto index = std::make_shared<ResultIndex>();
  for (const ArrayView& array : arrays) index->arrays.push_back(describe(array, identity));
  FileDescriptor file = write_all(path, arrays, *index, packed, identity);
  return {std::move(file), index};
}

std::shared_ptr<const ResultIndex> read_result_index(const std::filesystem::path& path, int file,
                                                     const ResultIdentity& identity) {
  struct stat status {};
  if (fstat(file, &status) != 0) throw_read_error(path, errno);
  refuse_directory(path);
  const auto file_bytes = static_cast<std::uint64_t>(status.st_size);
  const auto index = std::make_shared<ResultIndex>();
  const std::string problem = read_layout(path, file_bytes, identity, *index);
  if (!problem.empty()) throw CorruptResult(path, problem);
  for (StoredArray& array : index->arrays) {
    const std::uint64_t checksum_bytes = array.checksums.size() * sizeof(std::uint64_t);
    const bool inside =
        array.blocks.empty()
            ? fits(array, file_bytes) &&
                  lies_within(array.offset, array.rows * array.row_bytes(), file_bytes)
            : std::all_of(array.blocks.begin(), array.blocks.end(), [&](const StoredBlock& block) {
                return lies_within(block.offset, block.bytes, file_bytes);
              });
    if (!inside || !lies_within(array.checksum_offset, checksum_bytes, file_bytes))
      throw CorruptResult(path, "a truncated file");
    read_rows(path, file, array.checksums.data(), checksum_bytes, array.checksum_offset);
    index->file_bytes += data_bytes(array) + checksum_bytes;
  }
  return index;
}

}  // namespace orbweave
