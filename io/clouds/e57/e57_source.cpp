#include "io/clouds/e57/e57_source.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "io/clouds/e57/e57_columns.h"
#include "io/clouds/e57/e57_document.h"
#include "io/clouds/e57/e57_layout.h"
#include "io/clouds/e57/e57_left_out.h"
#include "io/clouds/e57/e57_pages.h"
#include "io/clouds/e57/e57_section.h"
#include "io/error.h"
#include "io/text/counted_noun.h"

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
  ScanNumber scan() const override { return {.scan = scan_}; }
  void skip_parts(const std::function<bool(const Box&)>& is_outside) override {
    is_outside_ = is_outside;
  }
  std::string coordinate_system() const override { return document_.coordinate_system; }

  FileFacts facts() const override {
    FileFacts facts;
    facts.format = "E57";
    facts.version = document_.version;
    facts.software = document_.software;
    for (std::size_t i = 0; i < document_.scans.size(); ++i) {
      const E57Scan& scan = document_.scans[i];
      facts.scans.push_back(
          {scan.given_name, scan.sensor, scan.records, scan.pose, place_of_scanner(i)});
    }
    facts.lost_values = lost_values_of_e57(document_.scans, layout_);
    if (document_.pictures > 0)
      facts.left_out.push_back(counted_noun(document_.pictures, "picture", "pictures"));
    return facts;
  }

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
      scanner_ = place_of_scanner(next_ - 1);
      scan_ = static_cast<std::uint32_t>(next_ - 1);
      const bool has_more = reader_->read(batch, capacity - batch.size());
      if (has_more) continue;
      close_scan();
      if (!batch.empty()) break;  // a batch is of one scan
    }
    return !batch.empty();
  }

 private:
  bool open_next() {
    while (next_ < document_.scans.size() && passes_over(next_)) ++next_;
    ended_ = next_ == document_.scans.size();
    if (ended_) return false;
    reader_.emplace(pages_, document_.scans[next_], layout_.scans[next_], layout_.schema);
    ++next_;
    return true;
  }

  /// A scan without points, or one outside of what is wanted: its points count as left out.
  bool passes_over(std::size_t scan) {
    if (document_.scans[scan].records == 0) return true;
    if (!is_outside_ || !lies_outside(scan)) return false;
    dropped_[kOutsideCrop] += document_.scans[scan].records;
    return true;
  }

  /// Whether the bounds of a scan are outside, and its first points do not contradict them.
  bool lies_outside(std::size_t scan) {
    constexpr std::uint64_t kLooked = 1024;
    const std::optional<Box> bounds = bounds_in_file(document_.scans[scan]);
    if (!bounds || !is_outside_(*bounds)) return false;
    PointCloud first;
    first.schema = layout_.schema;
    E57ScanReader reader(pages_, document_.scans[scan], layout_.scans[scan], layout_.schema);
    reader.read(first, kLooked);
    return std::ranges::all_of(first.positions, [&](Vec3 p) { return bounds->contains(p); });
  }

  /// The bounds of a scan in the coordinates of the file, with room for rounding to floats.
  static std::optional<Box> bounds_in_file(const E57Scan& scan) {
    if (!scan.bounds) return std::nullopt;
    const RigidMotion pose = scan.pose.value_or(RigidMotion{});
    const Box& own = *scan.bounds;
    Box box;
    double largest = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p = {(corner & 1) != 0 ? own.max.x : own.min.x,
                      (corner & 2) != 0 ? own.max.y : own.min.y,
                      (corner & 4) != 0 ? own.max.z : own.min.z};
      box.extend(pose.point(p));
      for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(p[axis]));
    }
    constexpr double kFloatRounding = 1e-6;
    return box.grown(kFloatRounding * largest);
  }

  void close_scan() {
    if (reader_->left_out() != 0) dropped_[reason()] += reader_->left_out();
    bytes_done_ += reader_->bytes_total();
    reader_.reset();
  }

  const char* reason() const {
    return layout_.scans[next_ - 1].is_spherical ? kNoReturn : kInvalidPosition;
  }

  std::optional<ScannerPlace> place_of_scanner(std::size_t scan) const {
    if (!layout_.scans[scan].has_scanner) return std::nullopt;
    const std::optional<RigidMotion>& pose = document_.scans[scan].pose;
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
  std::function<bool(const Box&)> is_outside_;  ///< empty: every scan is wanted
  std::optional<ScannerPlace> scanner_;
  std::uint32_t scan_ = 0;  ///< that the last batch is of
};

}  // namespace

std::unique_ptr<PointSource> open_e57_source(std::unique_ptr<RandomAccess> file) {
  return std::make_unique<E57Source>(std::move(file));
}

}  // namespace orbweave
