#include "engine/validation/scan_agreement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "engine/geometry/point_tree.h"
#include "engine/geometry/symmetric_eigen.h"
#include "engine/spacing/site_points.h"
#include "io/vec3_order.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// How much is looked at.
struct Look {
  std::size_t site_points = 0;  ///< of the sites together, which are taken in their order
  std::uint64_t per_scan = 0;   ///< points that are looked at, within limits
  std::uint64_t fewest = 0, most = 0;
};
/// A short look, and a long one where the short one leaves a doubt.
constexpr Look kShort{std::size_t{1} << 16, 8, 1024, 4096};
constexpr Look kLong{std::size_t{1} << 18, 64, 8192, 32768};
/// Meetings of a scan that may leave a doubt.
constexpr std::uint64_t kFewestDoubtful = 4;

/// Points of the first neighbourhood; each further one has twice as many.
constexpr std::size_t kFirstNeighbors = 12, kMostNeighbors = 96;
/// A neighbourhood is a surface where it is so many times as wide as its points deviate.
constexpr double kWide = 6.0;
/// A neighbourhood is a row of points where its width is a smaller part of its length.
constexpr double kRow = 0.3;

/// Surfaces farther apart, in spacings of the sparser scan, may be two things.
constexpr double kReach = 8.0;
/// One surface deviates by less: in spacings, beside the noise.
constexpr double kOff = 2.0;
constexpr double kSteep = 0.8;  ///< surfaces that meet at a smaller cosine cross each other

/// A scan is off where a larger share of its meetings is, of so many at least. (Real and simulated
/// scans: up to 0.15, trees 0.25. docs/results/normals.md)
constexpr double kOffShare = 0.25;
constexpr std::uint64_t kFewestMeetings = 16;
constexpr double kMargin = 1.0;  ///< beyond that, in roots of the number of meetings
/// The median distance is larger then, in spacings, as twigs cross each other in good scans, too.
constexpr double kBeside = 0.5;
/// Or where the median distance is larger than that, in spacings, and in deviations of both. (Real
/// scans: up to 0.25; scans that were moved by five spacings: 1 to 1.8.)
constexpr double kFarOff = 1.0, kFarOffNoise = 3.0;

/// The surface of one scan around a place.
struct Patch {
  Vec3 middle;
  Vec3 normal;  ///< of either side
  double deviation = 0.0;
  double radius = 0.0;
  double spacing = 0.0;
};

/// The points of one scan in a site.
struct ScanInSite {
  std::uint32_t scan = 0;
  std::vector<Vec3> points;  ///< in the order of their coordinates
  PointTree tree;
};

Patch patch_of(std::span<const Vec3> points, std::span<const Neighbor> found, Vec3 place,
               double& width, double& length) {
  const auto count = static_cast<double>(found.size());
  Vec3 sum;
  for (const Neighbor& n : found) sum = sum + (points[n.index] - place);
  const Vec3 mean = (1.0 / count) * sum;
  SymmetricMatrix moments;
  double farthest = 0.0;
  for (const Neighbor& n : found) {
    const Vec3 off = points[n.index] - place - mean;
    moments += outer(off);
    farthest = std::max(farthest, squared_norm(off));
  }
  const SymmetricEigen axes = eigen_of(moments);
  const auto root = [&](double value) { return std::sqrt(std::max(0.0, value) / count); };
  width = root(axes.values[1]);
  length = root(axes.values[2]);
  const double radius = std::sqrt(farthest);
  return {place + mean, axes.vectors[0], root(axes.values[0]), radius,
          radius * std::sqrt(std::numbers::pi / count)};
}

/// The nearest points as a plane, as many of them as make one.
std::optional<Patch> patch_at(const ScanInSite& scan, Vec3 place, std::vector<Neighbor>& found) {
  const std::size_t most = std::min(scan.points.size(), kMostNeighbors);
  for (std::size_t count = kFirstNeighbors; count <= most; count *= 2) {
    scan.tree.nearest(place, count, found);
    double width = 0.0, length = 0.0;
    const Patch patch = patch_of(scan.points, found, place, width, length);
    if (width < kRow * length) continue;
    if (patch.radius >= kWide * patch.deviation) return patch;
  }
  return std::nullopt;
}

/// Whether the patch is the surface around its own middle, too. What is nearest to a place beyond
/// the border of a scan lies where the border cuts the scan's surfaces: rows in one plane, which is
/// no surface.
bool is_surface(const ScanInSite& scan, const Patch& patch, std::vector<Neighbor>& found) {
  scan.tree.nearest(patch.middle, found.size(), found);
  double width = 0.0, length = 0.0;
  const Patch around = patch_of(scan.points, found, patch.middle, width, length);
  return around.radius >= kWide * around.deviation &&
         std::abs(dot(around.normal, patch.normal)) >= kSteep;
}

/// Whether the scan has points about as far from `place` as the two are apart, on its own side.
bool reaches(const ScanInSite& scan, Vec3 place, double distance) {
  constexpr double kNear = 0.7;
  return scan.tree.nearest(place).squared_distance <= kNear * kNear * distance * distance;
}

/// Whether each of two surfaces that cross goes on behind the other. Where scans end at one border,
/// as tiles do, none does.
bool cross_each_other(const ScanInSite& scan, const Patch& own, const ScanInSite& other,
                      const Patch& there) {
  constexpr double kBehind = 3.0;  ///< spacings of the sparser scan behind the crossing
  const Vec3 in_own = there.normal - dot(there.normal, own.normal) * own.normal;
  const Vec3 in_other = own.normal - dot(own.normal, there.normal) * there.normal;
  const double sine = norm(in_own);
  const double off = dot(own.middle - there.middle, there.normal);
  const Vec3 crossing = own.middle - (off / (sine * sine)) * in_own;
  const double behind =
      std::max(norm(crossing - own.middle), kBehind * std::max(own.spacing, there.spacing));
  const auto goes_on = [&](const ScanInSite& one, Vec3 along) {
    const Vec3 step = (behind / norm(along)) * along;
    return reaches(one, crossing + step, behind) && reaches(one, crossing - step, behind);
  };
  return goes_on(scan, in_own) && goes_on(other, in_other);
}

/// From the surface to its scanner, as the sign of the normal: 0 where that is not known.
double side_of(const Patch& patch, const std::optional<ScannerPlace>& scanner) {
  if (!scanner) return 0.0;
  const Vec3 view = scanner->is_direction ? scanner->vector : scanner->vector - patch.middle;
  const double along = dot(patch.normal, view);
  return along > 0.0 ? 1.0 : along < 0.0 ? -1.0 : 0.0;
}

/// Two scans at one place.
struct Meeting {
  std::uint32_t scan = 0, other = 0;
  bool is_off = false;
  double distance = 0.0;
  double spacings = 0.0;
  double noise = 0.0;      ///< deviations of both, likewise in spacings
  bool has_sides = false;  ///< both are known to face the same way
};

class Looker {
 public:
  explicit Looker(std::span<const std::optional<ScannerPlace>> scanners) : scanners_(scanners) {}

  /// Nothing where the two do not meet, or nothing can be said about it.
  std::optional<Meeting> look(const ScanInSite& scan, const Patch& own, const ScanInSite& other,
                              std::vector<Neighbor>& found) const {
    if (other.points.size() < kFirstNeighbors) return std::nullopt;
    const double reach = kReach * kMostCoarser * own.spacing;
    if (other.tree.nearest(own.middle).squared_distance > reach * reach) return std::nullopt;
    const std::optional<Patch> there = patch_at(other, own.middle, found);
    if (!there) return std::nullopt;
    const double spacing = std::max(own.spacing, there->spacing);
    const Vec3 between = own.middle - there->middle;
    const double off = dot(between, there->normal);
    const Vec3 along = between - off * there->normal;
    constexpr double kInside = 0.5;  // of the radius: the border of a scan tells nothing
    if (norm(along) > kInside * there->radius || std::abs(off) > kReach * spacing)
      return std::nullopt;
    const double cosine = dot(own.normal, there->normal);
    const double sides = side_of(own, scanners_[scan.scan]) *
                         side_of(*there, scanners_[other.scan]) * (cosine < 0.0 ? -1.0 : 1.0);
    if (sides < 0.0 || !is_surface(other, *there, found)) return std::nullopt;
    const bool is_beside =
        sides > 0.0 && std::abs(off) > kOff * spacing + own.deviation + there->deviation;
    const bool is_steep = std::abs(cosine) < kSteep;
    if (is_steep && !is_beside && !cross_each_other(scan, own, other, *there)) return std::nullopt;
    return Meeting{scan.scan,
                   other.scan,
                   is_beside || is_steep,
                   std::abs(off),
                   std::abs(off) / spacing,
                   (own.deviation + there->deviation) / spacing,
                   sides > 0.0};
  }

 private:
  static constexpr double kMostCoarser = 8.0;  ///< scans of other spacing are not looked for
  std::span<const std::optional<ScannerPlace>> scanners_;
};

/// The points of a site, scan by scan.
std::vector<ScanInSite> scans_in(const SpacingSite& site,
                                 std::span<const std::uint32_t> scan_of_point) {
  std::map<std::uint32_t, std::vector<Vec3>> points;
  for (std::size_t i = 0; i < site.points.size(); ++i)
    points[scan_of_point[i]].push_back(site.points[i]);
  std::vector<ScanInSite> scans;
  for (auto& [scan, own] : points) {
    std::ranges::sort(own, comes_before);
    // Moving the vector leaves its points where the tree looks for them.
    PointTree tree(own);
    scans.push_back({scan, std::move(own), std::move(tree)});
  }
  return scans;
}

std::vector<Meeting> meetings_at(const SpacingSite& site,
                                 std::span<const std::uint32_t> scan_of_point,
                                 const PointSelection& selection, const Looker& looker,
                                 const StopToken* stop) {
  const std::vector<ScanInSite> scans = scans_in(site, scan_of_point);
  if (scans.size() < 2) return {};
  std::vector<std::pair<std::size_t, Vec3>> places;
  for (std::size_t s = 0; s < scans.size(); ++s)
    for (const Vec3& p : scans[s].points)
      if (selection.takes(p) && site.core.contains(p)) places.emplace_back(s, p);
  std::vector<std::vector<Meeting>> at_place(places.size());
  for_each_whole(places.size(), [&](std::size_t i) {
    check_stop(stop);
    const auto& [own, place] = places[i];
    std::vector<Neighbor> found;
    const std::optional<Patch> patch = patch_at(scans[own], place, found);
    if (!patch) return;
    for (const ScanInSite& other : scans)
      if (other.scan != scans[own].scan)
        if (const auto meeting = looker.look(scans[own], *patch, other, found))
          at_place[i].push_back(*meeting);
  });
  std::vector<Meeting> all;
  for (const auto& some : at_place) all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// The sites that are looked at. The first may be the whole of a small cloud.
std::vector<std::size_t> sites_looked_at(std::span<const SpacingSite> sites, std::size_t most) {
  std::vector<std::size_t> chosen;
  std::size_t points = 0;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    const std::size_t size = sites[s].points.size();
    if (points + size > (s == 0 ? kLong.site_points : most)) continue;
    points += size;
    chosen.push_back(s);
  }
  return chosen;
}

std::vector<Meeting> all_meetings(std::span<const SpacingSite> sites,
                                  std::span<const std::vector<std::uint32_t>> scan_of_point,
                                  std::span<const std::optional<ScannerPlace>> scanners,
                                  const Look& how, const StopToken* stop) {
  const std::vector<std::size_t> chosen = sites_looked_at(sites, how.site_points);
  std::uint64_t points = 0;
  for (const std::size_t s : chosen) points += sites[s].points.size();
  const std::uint64_t wanted = std::clamp(how.per_scan * scanners.size(), how.fewest, how.most);
  PointSelection selection;
  if (points > wanted) selection.last = ~std::uint64_t{0} / points * wanted;
  const Looker looker(scanners);
  std::vector<std::vector<Meeting>> at_site(chosen.size());
  for_each_whole(chosen.size(), [&](std::size_t i) {
    check_stop(stop);
    const std::size_t s = chosen[i];
    at_site[i] = meetings_at(sites[s], scan_of_point[s], selection, looker, stop);
  });
  std::vector<Meeting> all;
  for (const auto& some : at_site) all.insert(all.end(), some.begin(), some.end());
  return all;
}

/// The meetings of one scan.
struct Counts {
  std::uint64_t meetings = 0, off = 0;
  std::vector<double> spacings;
  std::vector<double> spacings_of_sides, noise_of_sides;  ///< where the sides are known
};

/// Whether a larger share of a's meetings is off.
bool is_worse(const Counts& a, const Counts& b) {
  const auto off = [](const Counts& one, const Counts& other) { return one.off * other.meetings; };
  return off(a, b) != off(b, a) ? off(a, b) > off(b, a) : a.meetings > b.meetings;
}

/// 0 of no values.
double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// `margin`: in roots of the number of meetings, so that few have to say it more clearly.
bool is_off(const Counts& counts, std::uint64_t fewest, double margin) {
  if (counts.meetings < fewest) return false;
  const auto meetings = static_cast<double>(counts.meetings);
  if (static_cast<double>(counts.off) > kOffShare * meetings + margin * std::sqrt(meetings) &&
      median(counts.spacings) > kBeside)
    return true;
  if (counts.spacings_of_sides.size() < fewest) return false;
  const double far = median(counts.spacings_of_sides);
  return far > kFarOff && far > kFarOffNoise * median(counts.noise_of_sides);
}

std::vector<Counts> counted(std::span<const Meeting> meetings, std::size_t scans) {
  std::vector<Counts> of_scan(scans);
  for (const Meeting& m : meetings)
    for (const std::uint32_t scan : {m.scan, m.other}) {
      ++of_scan[scan].meetings;
      of_scan[scan].off += m.is_off ? 1 : 0;
      of_scan[scan].spacings.push_back(m.spacings);
      if (!m.has_sides) continue;
      of_scan[scan].spacings_of_sides.push_back(m.spacings);
      of_scan[scan].noise_of_sides.push_back(m.noise);
    }
  return of_scan;
}

/// What the scan's meetings with scans that are left say of it.
OffScan described(std::size_t scan, std::span<const Meeting> meetings) {
  OffScan one{.scan = scan};
  std::vector<double> distances, spacings;
  struct Beside {
    std::uint64_t off = 0, meetings = 0;
    auto operator<=>(const Beside&) const = default;
  };
  std::map<std::size_t, Beside> beside;
  for (const Meeting& m : meetings) {
    if (m.scan != scan && m.other != scan) continue;
    ++one.meetings;
    one.off += m.is_off ? 1 : 0;
    distances.push_back(m.distance);
    spacings.push_back(m.spacings);
    Beside& other = beside[m.scan == scan ? m.other : m.scan];
    ++other.meetings;
    other.off += m.is_off ? 1 : 0;
  }
  one.distance = median(std::move(distances));
  one.spacings = median(std::move(spacings));
  one.beside = std::ranges::max_element(beside, {}, [](const auto& b) { return b.second; })->first;
  return one;
}

}  // namespace

std::vector<OffScan> scans_off_surface(std::span<const SpacingSite> sites,
                                       std::span<const std::vector<std::uint32_t>> scan_of_point,
                                       std::span<const std::optional<ScannerPlace>> scanners,
                                       const StopToken* stop) {
  std::vector<Meeting> left = all_meetings(sites, scan_of_point, scanners, kShort, stop);
  const auto leaves_a_doubt = [](const Counts& one) { return is_off(one, kFewestDoubtful, 0.0); };
  if (std::ranges::none_of(counted(left, scanners.size()), leaves_a_doubt)) return {};
  left = all_meetings(sites, scan_of_point, scanners, kLong, stop);
  std::vector<OffScan> off;
  while (true) {
    const std::vector<Counts> of_scan = counted(left, scanners.size());
    std::optional<std::size_t> worst;
    for (std::size_t scan = 0; scan < of_scan.size(); ++scan)
      if (is_off(of_scan[scan], kFewestMeetings, kMargin) &&
          (!worst || is_worse(of_scan[scan], of_scan[*worst])))
        worst = scan;
    if (!worst) return off;
    off.push_back(described(*worst, left));
    std::erase_if(left, [&](const Meeting& m) { return m.scan == *worst || m.other == *worst; });
  }
}

}  // namespace orbweave
