#include "engine/pipeline/output/placed_export.h"

#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "io/system/atomic_file.h"
#include "io/system/placed_file.h"

namespace orbweave {
namespace {

constexpr const char* kExportStage = directory_of(Stage::kExport);
constexpr const char* kPartDocument = "part";

bool is_regular_or_absent(const std::filesystem::path& target) {
  std::error_code absent;
  const auto status = std::filesystem::status(target, absent);
  return !std::filesystem::exists(status) || std::filesystem::is_regular_file(status);
}

/// Where the rows of a mesh lie in its file.
class FileLayout {
 public:
  FileLayout(const MeshRows& rows, const MeshHeader& header)
      : rows_(rows), header_(header), front_bytes_(rows.front({}).size()) {}

  std::string front(const Box& bounds) const { return rows_.front(bounds); }
  std::uint64_t bytes() const {
    return front_bytes_ + header_.vertices * rows_.vertex_bytes() +
           header_.triangles * rows_.triangle_bytes();
  }
  /// Puts a piece into the buffer as it will be in the file.
  void encode(const MeshPiece& piece, const PieceRows& rows, PlacedBuffer& buffer) const {
    if (piece.has_vertices()) {
      const std::uint64_t offset = front_bytes_ + piece.row * rows_.vertex_bytes();
      rows_.put_vertices(rows.vertices, buffer.place(offset, piece.rows * rows_.vertex_bytes()));
      return;
    }
    const std::uint64_t offset =
        front_bytes_ + header_.vertices * rows_.vertex_bytes() + piece.row * rows_.triangle_bytes();
    const std::span<const std::int32_t> hole(rows.hole);
    rows_.put_triangles(rows.triangles, header_.has_hole ? hole : hole.first(0),
                        buffer.place(offset, piece.rows * rows_.triangle_bytes()));
  }

 private:
  const MeshRows& rows_;
  const MeshHeader& header_;
  std::uint64_t front_bytes_;
};

/// The file on its way.
class PlacedExport {
 public:
  PlacedExport(StageRunner& runner, const MeshPieces& pieces, const VertexColumns& columns,
               const MeshHeader& header, const MeshRows& rows, SurfaceDigest& digest)
      : runner_(runner),
        pieces_(pieces),
        columns_(columns),
        layout_(rows, header),
        digest_(digest),
        in_flight_(pieces_in_flight(runner.job, columns.stored)) {}

  std::uint64_t bytes() const { return layout_.bytes(); }

  void run_alone() {
    AtomicFile target(runner_.job.output.mesh);
    PlacedFile file(target.temporary(), runner_.job.output.mesh);
    begin(file);
    WriteBehind writer(file, in_flight_ + 2);
    run_in_order(
        runner_, pieces_.all(), in_flight_,
        [&](const MeshPiece& piece, PieceRows& rows) {
          pieces_.load(piece, columns_, rows);
          rows.placed = writer.take();
          layout_.encode(piece, rows, *rows.placed);
        },
        [&](const MeshPiece& piece, PieceRows& rows) {
          digest_.add(rows.digest);
          writer.give(std::move(rows.placed));
          runner_.progress.advance(piece.stored);
        });
    writer.finish();
    write_front(file);
    target.commit();
  }

  bool run_in_team() {
    std::optional<AtomicFile> target;
    if (runner_.communicator.is_root()) {
      const bool placed = is_regular_or_absent(runner_.job.output.mesh);
      if (placed) {
        // The file has its full size before another process opens it: an NFS client fills the last
        // page of what it takes for the whole file with zeros, over what others write there.
        target.emplace(runner_.job.output.mesh);
        PlacedFile file(target->temporary(), runner_.job.output.mesh);
        begin(file);
        file.flush();
      }
      runner_.store.commit_document(kExportStage, kPartDocument,
                                    placed ? target->temporary().string() : "");
    }
    runner_.communicator.barrier(runner_.stop);
    const std::string part = runner_.store.expected_document(kExportStage, kPartDocument);
    if (part.empty()) return false;
    PlacedFile file(part, runner_.job.output.mesh);
    runner_.communicator.reset_counter(runner_.stop);
    share_pieces(file);
    file.flush();
    runner_.communicator.barrier(runner_.stop, [&] { show_done_by_others(); });
    const std::vector<std::string> digests =
        runner_.communicator.gather(digest_.text(), runner_.stop);
    if (!runner_.communicator.is_root()) return true;
    for (std::size_t rank = 1; rank < digests.size(); ++rank)
      digest_.add(SurfaceDigest::from_text(digests[rank]));
    write_front(file);
    file.flush();
    target->commit();
    return true;
  }

 private:
  void begin(PlacedFile& file) const { file.reserve(layout_.bytes()); }

  /// When the bounds of all vertices are known.
  void write_front(PlacedFile& file) const {
    const std::string front = layout_.front(digest_.bounds());
    file.write(0, std::as_bytes(std::span(front)));
  }

  void share_pieces(PlacedFile& file) {
    std::vector<ChunkTask> tasks;
    for (std::size_t i = 0; i < pieces_.all().size(); ++i) {
      tasks.push_back({static_cast<ChunkId>(i), 1, pieces_.all()[i].stored});
    }
    WriteBehind writer(file, in_flight_ + 2);
    // A "byte" of the budget is a piece.
    run_chunks(
        tasks,
        {runner_.threads(), in_flight_, &runner_.stop, &runner_.communicator, runner_.root_threads},
        [&](ChunkId task) {
          const MeshPiece& piece = pieces_.all()[task];
          std::unique_ptr<PieceRows> rows = take_rows();
          pieces_.load(piece, columns_, *rows);
          auto buffer = writer.take();
          layout_.encode(piece, *rows, *buffer);
          writer.give(std::move(buffer));
          give_rows(std::move(rows), piece.stored);
        });
    writer.finish();
  }

  std::unique_ptr<PieceRows> take_rows() {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) return std::make_unique<PieceRows>();
    std::unique_ptr<PieceRows> rows = std::move(free_.back());
    free_.pop_back();
    return rows;
  }
  void give_rows(std::unique_ptr<PieceRows> rows, std::uint64_t done) {
    runner_.communicator.add_done(done, 0);
    runner_.progress.advance(done);
    const std::scoped_lock lock(mutex_);
    digest_.add(rows->digest);
    free_.push_back(std::move(rows));
    show_done_by_others();
  }
  void show_done_by_others() {
    if (runner_.communicator.is_root())
      runner_.progress.advance(runner_.communicator.done_by_others().units);
  }

  StageRunner& runner_;
  const MeshPieces& pieces_;
  const VertexColumns& columns_;
  FileLayout layout_;
  SurfaceDigest& digest_;
  std::size_t in_flight_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<PieceRows>> free_;
};

}  // namespace

bool export_placed(StageRunner& runner, const MeshPieces& pieces, const VertexColumns& columns,
                   const MeshHeader& header, const MeshRows& rows, SurfaceDigest& digest,
                   std::uint64_t& bytes_written) {
  PlacedExport placed(runner, pieces, columns, header, rows, digest);
  bytes_written = placed.bytes();
  if (runner.communicator.size() > 1) return placed.run_in_team();
  if (!is_regular_or_absent(runner.job.output.mesh)) return false;
  placed.run_alone();
  return true;
}

}  // namespace orbweave
