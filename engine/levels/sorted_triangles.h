// The triangles of a mesh of any size in the order of the octree's cells, sorted on disk.
#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "io/meshes/mesh_stream.h"
#include "io/stop_token.h"
#include "io/system/spool_file.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// A triangle, the Morton code of the cell that its centroid lies in, and the hole that it fills.
struct CodedTriangle {
  std::uint64_t code = 0;
  Triangle64 corners{};
  FacePatch patch{};
  friend auto operator<=>(const CodedTriangle&, const CodedTriangle&) = default;
};

/// All triangles, ascending by code, then by their corners. Thread-safe.
class SortedTriangles {
 public:
  SortedTriangles(std::unique_ptr<SpoolFile> file, std::uint64_t offset, std::uint64_t size)
      : file_(std::move(file)), offset_(offset), size_(size) {}
  std::uint64_t size() const { return size_; }
  std::uint64_t disk_bytes() const { return file_->bytes(); }
  std::vector<CodedTriangle> read(std::uint64_t first, std::uint64_t count) const;
  /// The first triangle of [first, last) whose code is not below `code`; else last.
  std::uint64_t first_at_least(std::uint64_t code, std::uint64_t first, std::uint64_t last) const;

 private:
  std::unique_ptr<SpoolFile> file_;
  std::uint64_t offset_;
  std::uint64_t size_;
};

/// Takes triangles in any order: sorts runs in memory and merges them on disk. What comes out does
/// not depend on the size of the runs.
class TriangleSorter {
 public:
  /// `run_bytes`: memory of a run; sorting takes that and a few megabytes more.
  TriangleSorter(std::filesystem::path directory, std::size_t run_bytes);
  void add(const CodedTriangle& triangle);
  SortedTriangles finish(const StopToken& stop);

 private:
  /// Part of the file.
  struct Run {
    std::uint64_t offset = 0;
    std::uint64_t size = 0;
  };
  void write_run();
  SortedTriangles merged(const StopToken& stop) const;

  std::filesystem::path directory_;
  std::size_t most_;
  std::vector<CodedTriangle> triangles_;
  std::vector<Run> runs_;
  std::unique_ptr<SpoolFile> file_;
};

}  // namespace orbweave
