#include "io/clouds/e57/e57_source.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "io/clouds/e57/e57_columns.h"
#include "io/clouds/e57/e57_document.h"
#include "io/clouds/e57/e57_layout.h"
#include "io/clouds/e57/e57_pages.h"
#include "io/clouds/e57/e57_section.h"
#include "io/error.h"

namespace orbweave {
namespace {

constexpr const char* kInvalidPosition = "invalid position";
constexpr const char* kNoReturn = "no return";

/// Checks every scan's section before the first point is read. Scans that shared bytes could make
/// a small file yield any number of points.
void check_sections(E57Pages& pages, const std::vector<E57Scan>& scans) {
  std::vector<std::pair<E57Section, const E57Scan*>> sections;
  for (const E57Scan& scan : scans) sections.emplace_back(read_e57_section(pages, scan), &scan);
  std::stable_sort(sections.begin(), sections.end(),
                   [](const auto& a, const auto& b) { return a.first.begin < b.first.begin; });
  for (std::size_t i = 1; i < sections.size(); ++i)
    if (sections[i].first.begin < sections[i - 1].first.end)
      throw_bad_input("the sections of " + sections[i - 1].second->label + " and " +
                          sections[i].second->label + " overlap",
                      {.file = pages.name(), .place = pages.place(sections[i].first.begin)});
}

class E57Source final : public PointSource {
 public:
  explicit E57Source(std::unique_ptr<RandomAccess> file)
      : pages_(std::move(file)),
        document_(read_e57_document(pages_)),
        layout_(plan_e57_layout(document_.scans, pages_.name())) {
    check_sections(pages_, document_.scans);
  }

  const PointSchema& schema() const override { return layout_.schema; }
  std::uint64_t bytes_total() const override { return pages_.file().size(); }
  std::uint64_t bytes_read() const override {
    if (ended_) return bytes_total();
    return bytes_done_ + (reader_ ? reader_->bytes_read() : 0);
  }
  std::optional<ScannerPlace> scanner() const override { return scanner_; }
  std::string coordinate_system() const override { return document_.coordinate_system; }

  /// Nothing where points may turn out to have no position.
  std::optional<std::uint64_t> declared_points() const override {
    std::uint64_t points = 0;
    for (std::size_t i = 0; i < document_.scans.size(); ++i) {
      const E57Scan& scan = document_.scans[i];
      const auto state = layout_.scans[i].invalid_state;
      if (state && scan.fields[*state].bits != 0 && scan.records != 0) return std::nullopt;
      points += scan.records;
    }
    return points;
  }

  DroppedPoints left_out() const override {
    DroppedPoints dropped = dropped_;
    if (reader_ && reader_->left_out() != 0) dropped[reason()] += reader_->left_out();
    return dropped;
  }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.schema = layout_.schema;
    batch.clear();
    while (batch.size() < capacity && (reader_ || open_next())) {
      scanner_ = place_of_scanner();
      const bool has_more = reader_->read(batch, capacity - batch.size());
      if (has_more) continue;
      close_scan();
      if (!batch.empty()) break;  // a batch is of one scan
    }
    return !batch.empty();
  }

 private:
  bool open_next() {
    while (next_ < document_.scans.size() && document_.scans[next_].records == 0) ++next_;
    ended_ = next_ == document_.scans.size();
    if (ended_) return false;
    reader_.emplace(pages_, document_.scans[next_], layout_.scans[next_], layout_.schema);
    ++next_;
    return true;
  }

  void close_scan() {
    if (reader_->left_out() != 0) dropped_[reason()] += reader_->left_out();
    bytes_done_ += reader_->bytes_total();
    reader_.reset();
  }

  const char* reason() const {
    return layout_.scans[next_ - 1].is_spherical ? kNoReturn : kInvalidPosition;
  }

  std::optional<ScannerPlace> place_of_scanner() const {
    if (!layout_.scans[next_ - 1].has_scanner) return std::nullopt;
    const std::optional<RigidMotion>& pose = document_.scans[next_ - 1].pose;
    return ScannerPlace{.vector = pose ? pose->translation : Vec3{}};
  }

  E57Pages pages_;
  E57Document document_;
  E57Layout layout_;
  std::optional<E57ScanReader> reader_;  ///< of scan next_ - 1
  std::size_t next_ = 0;
  std::uint64_t bytes_done_ = 0;
  bool ended_ = false;
  DroppedPoints dropped_;
  std::optional<ScannerPlace> scanner_;
};

}  // namespace

std::unique_ptr<PointSource> open_e57_source(std::unique_ptr<RandomAccess> file) {
  return std::make_unique<E57Source>(std::move(file));
}

}  // namespace orbweave
