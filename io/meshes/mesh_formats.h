// The writers behind open_mesh_writer, one per format.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "io/meshes/mesh_writer.h"
#include "io/streams/byte_sink.h"

namespace orbweave {

std::unique_ptr<MeshWriter> make_ply_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options);
/// The rows of a binary PLY file.
std::unique_ptr<MeshRows> make_ply_rows(const MeshHeader& header, const MeshWriterOptions& options);
std::unique_ptr<MeshWriter> make_obj_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options);
/// `path`: of the STL file; beside it the vertices wait, in an unlinked file, until the triangles
/// need them.
std::unique_ptr<MeshWriter> make_stl_writer(std::unique_ptr<ByteSink> sink,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options,
                                            const std::filesystem::path& path);
/// GLB: its front is written last, so the path has to be that of a regular file.
std::unique_ptr<MeshWriter> make_glb_writer(const std::filesystem::path& path,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options);
/// VTK XML PolyData: columns at their places, so the path has to be that of a regular file.
std::unique_ptr<MeshWriter> make_vtp_writer(const std::filesystem::path& path,
                                            const MeshHeader& header,
                                            const MeshWriterOptions& options);
/// XDMF, with its columns in an HDF5 file beside it: likewise.
std::unique_ptr<MeshWriter> make_xdmf_writer(const std::filesystem::path& path,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options);
/// A cloud as text: separator ' ' without header line, or ',' with one.
std::unique_ptr<MeshWriter> make_text_writer(std::unique_ptr<ByteSink> sink,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options, char separator);

/// Counts what went through and refuses a writer's misuse (std::logic_error: a defect of the
/// caller, not of the user's data).
class RowCounter {
 public:
  RowCounter() = default;
  explicit RowCounter(const MeshHeader& header)
      : vertices_left_(header.vertices), triangles_left_(header.triangles) {}
  void vertices(std::uint64_t count);
  void triangles(std::uint64_t count);
  void finish() const;
  std::uint64_t vertices_left() const { return vertices_left_; }

 private:
  std::uint64_t vertices_left_ = 0;
  std::uint64_t triangles_left_ = 0;
};

/// A writer whose bytes do not depend on what came before: encoding is pure, writing is counting
/// and appending.
class IndependentWriter : public MeshWriter {
 public:
  IndependentWriter(std::unique_ptr<ByteSink> sink, const MeshHeader& header)
      : sink_(std::move(sink)), counter_(header) {}
  bool encodes_independently() const override { return true; }
  void write_vertices(const PointCloud& batch) override {
    write_encoded_vertices(encode_vertices(batch), batch.size());
  }
  void write_triangles(std::span<const Triangle64> batch,
                       std::span<const std::int32_t> hole) override {
    write_encoded_triangles(encode_triangles(batch, hole), batch.size());
  }
  void write_encoded_vertices(std::span<const std::byte> bytes, std::uint64_t vertices) override {
    counter_.vertices(vertices);
    sink_->write(bytes);
  }
  void write_encoded_triangles(std::span<const std::byte> bytes, std::uint64_t triangles) override {
    counter_.triangles(triangles);
    sink_->write(bytes);
  }
  void write_polygons(const PolygonFaces& faces) override {
    constexpr std::size_t kBatchFaces = std::size_t{1} << 16;
    for (std::size_t first = 0; first < faces.size(); first += kBatchFaces) {
      const std::size_t end = std::min(first + kBatchFaces, faces.size());
      write_encoded_triangles(encode_polygons(faces, first, end), end - first);
    }
  }
  void finish() override {
    counter_.finish();
    sink_->finish();
  }
  std::uint64_t bytes_written() const override { return sink_->bytes_written(); }

 protected:
  ByteSink& sink() { return *sink_; }
  /// Faces `first` to `end` (exclusive).
  virtual std::vector<std::byte> encode_polygons(const PolygonFaces&, std::size_t /*first*/,
                                                 std::size_t /*end*/) const {
    throw std::logic_error("the format has no polygons");
  }

 private:
  std::unique_ptr<ByteSink> sink_;
  RowCounter counter_;
};

/// Text put together in memory. Numbers are the shortest that read back as the same value.
class TextBuilder {
 public:
  void add(char c) { bytes_.push_back(static_cast<std::byte>(c)); }
  void add(std::string_view text) {
    const auto* from = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), from, from + text.size());
  }
  template <class T>
  void add_number(T value) {
    constexpr std::size_t kLongest = 32;  // of any number's shortest form
    char text[kLongest];
    const auto [end, error] = std::to_chars(text, text + kLongest, value);
    add(std::string_view(text, static_cast<std::size_t>(end - text)));
  }
  /// A stored value of that type.
  void add_value(ScalarType type, const std::byte* from);
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace orbweave
