#include "io/report/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "io/report/picture_samples.h"

namespace orbweave {
namespace {

constexpr int kLargestSize = 16384;
constexpr double kMargin = 0.04;      ///< of the picture, left free on every side
constexpr double kMostlyBacks = 0.6;  ///< share of back faces, as of a room seen from outside

constexpr Colour kFront{232.0, 224.0, 210.0};
constexpr Colour kBack{196.0, 84.0, 66.0};
constexpr Colour kLarge{110.0, 20.0, 140.0};  // of a number that is 1
constexpr Colour kDoubt{245.0, 150.0, 20.0};  // of a patch without any confidence

/// A value of 0 to 255 per channel, red highest.
std::uint32_t packed(Colour colour, double light) {
  const auto channel = [light](double value) {
    return static_cast<std::uint32_t>(std::clamp(value * light + 0.5, 0.0, 255.0));
  };
  return channel(colour.red) << 16 | channel(colour.green) << 8 | channel(colour.blue);
}

/// Whether the shape is low along `axis` (0 to 2), less than `part` of how wide it is along each of
/// the others.
bool is_low_along(int axis, const Box& bounds, double part) {
  const Vec3 extent = bounds.extent();
  return extent[axis] < part * std::min(extent[(axis + 1) % 3], extent[(axis + 2) % 3]);
}

/// Where an eye at azimuth 0 and elevation 0 has its right, its top and itself.
struct Directions {
  Vec3 right, up, front;
};

Directions directions_of(int up_axis) {
  if (up_axis == 0) return {{0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}};
  if (up_axis == 1) return {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  return {{1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, -1.0, 0.0}};
}

/// A vertex in samples: x to the right, y down, z towards the eye (world units).
struct Projected {
  double x, y, z;
  bool is_finite() const { return std::isfinite(x + y + z); }
};

}  // namespace

int upright_axis(UpAxis wanted, const Box& bounds) {
  // Buildings, rooms and terrain, which surveyors scan with z upright, are wider than high. Of
  // statues and models, which stand in y, few are half as deep as they are wide and high.
  constexpr double kLow = 0.5;
  if (wanted == UpAxis::kAuto) return is_low_along(2, bounds, kLow) ? 2 : 1;
  return static_cast<int>(wanted) - static_cast<int>(UpAxis::kX);
}

/// From the world to the samples.
struct MeshPicture::View {
  View(const Box& bounds, const PictureOptions& options, bool from_below = false);

  Projected project(Vec3 p) const {
    const Vec3 q = p - center;
    return {dot(q, right) + middle_x, dot(q, down) + middle_y, dot(q, eye)};
  }
  double light(Vec3 unit_normal) const;

  Vec3 center;
  Vec3 eye;          ///< unit vector towards the eye
  Vec3 right, down;  ///< samples per world unit
  Vec3 lamp;         ///< unit vector towards the light
  double middle_x = 0.0, middle_y = 0.0;
  double samples_per_unit = 1.0;

 private:
  void look(const Box& bounds, const PictureOptions& options, bool from_below);
  void fit(const Box& bounds, const PictureOptions& options);
};

MeshPicture::View::View(const Box& bounds, const PictureOptions& options, bool from_below) {
  middle_x = 0.5 * kSamplesPerAxis * options.width;
  middle_y = 0.5 * kSamplesPerAxis * options.height;
  if (!bounds.empty()) center = bounds.min + 0.5 * (bounds.max - bounds.min);
  look(bounds, options, from_below);
  fit(bounds, options);
}

void MeshPicture::View::look(const Box& bounds, const PictureOptions& options, bool from_below) {
  const int axis = upright_axis(options.up, bounds);
  const double degree = std::numbers::pi / 180.0;
  constexpr double kFlat = 0.25;
  const double azimuth = options.azimuth_deg * degree;
  const double elevation =
      options.elevation_deg.value_or(is_low_along(axis, bounds, kFlat) ? 40.0 : 20.0) * degree;
  const double level = std::cos(elevation), above = std::sin(elevation);
  const double height = from_below ? -above : above;
  const double aside = std::sin(azimuth), ahead = std::cos(azimuth);
  const Directions to = directions_of(axis);
  eye = level * (aside * to.right + ahead * to.front) + height * to.up;
  right = ahead * to.right - aside * to.front;
  down = cross(right, eye);
  lamp = normalized(eye - 0.45 * right - (from_below ? -0.65 : 0.65) * down);
}

/// The largest scale at which the box's corners are inside the margins.
void MeshPicture::View::fit(const Box& bounds, const PictureOptions& options) {
  double reach_x = 0.0, reach_y = 0.0;
  const Vec3 half = 0.5 * bounds.extent();
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 q{corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y,
                 corner & 4 ? half.z : -half.z};
    reach_x = std::max(reach_x, std::abs(dot(q, right)));
    reach_y = std::max(reach_y, std::abs(dot(q, down)));
  }
  const double usable = kSamplesPerAxis * (0.5 - kMargin);
  const double scale_x = usable * options.width / reach_x;
  const double scale_y = usable * options.height / reach_y;
  const double scale = std::min(scale_x, scale_y);
  samples_per_unit = std::isfinite(scale) && scale > 0.0 ? scale : 1.0;
  right = samples_per_unit * right;
  down = samples_per_unit * down;
}

/// Lambert's law, softened so that nothing seen is black.
double MeshPicture::View::light(Vec3 unit_normal) const {
  const double facing = std::max(0.0, dot(unit_normal, lamp));
  return 0.38 + 0.64 * facing;
}

namespace {

/// Twice the signed area of a, b, p. The same number but for the sign whichever way round the
/// edge is given, so that a sample on an edge is never lost between two triangles.
double edge_side(const Projected& a, const Projected& b, double x, double y) {
  const bool swapped = b.x < a.x || (b.x == a.x && b.y < a.y);
  const Projected& from = swapped ? b : a;
  const Projected& to = swapped ? a : b;
  const double side = (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x);
  return swapped ? -side : side;
}

/// Samples whose centres lie in [low, high], of `count` in all.
struct SampleRange {
  SampleRange(double low, double high, int count)
      : first(static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, count + 0.0))),
        last(static_cast<int>(std::clamp(std::floor(high - 0.5), -1.0, count - 1.0))) {}
  int first, last;
};

/// The samples of a row between which a line from `a` to `b` may pass, and one more on each side:
/// narrows a row of a large triangle, while edge_side decides at every sample that is left.
class RowSpan {
 public:
  RowSpan(const SampleRange& columns, double y) : columns_(columns), y_(y) {}
  void reach(const Projected& a, const Projected& b) {
    const double top = std::min(a.y, b.y), bottom = std::max(a.y, b.y);
    if (bottom < y_ || top > y_) return;
    if (bottom == top) {
      extend(std::min(a.x, b.x));
      extend(std::max(a.x, b.x));
    } else {
      extend(a.x + (y_ - a.y) / (b.y - a.y) * (b.x - a.x));
    }
  }
  int first() const { return clamped(low_ - 1.5); }
  int last() const { return clamped(high_ + 1.5); }

 private:
  void extend(double x) {
    low_ = std::min(low_, x);
    high_ = std::max(high_, x);
  }
  int clamped(double x) const {
    return static_cast<int>(std::clamp(x, columns_.first + 0.0, columns_.last + 0.0));
  }
  SampleRange columns_;
  double y_;
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

using Corners = std::array<Vec3, 3>;

/// A dot of a pixel or two.
void put_dot(const Projected& at, std::uint32_t colour, bool is_back, PictureSamples& samples) {
  constexpr double kReach = 1.6;  // samples around the point: a pixel and a half
  const SampleRange columns(at.x - kReach, at.x + kReach, samples.width());
  const SampleRange rows(at.y - kReach, at.y + kReach, samples.height());
  for (int row = rows.first; row <= rows.last; ++row)
    for (int column = columns.first; column <= columns.last; ++column)
      samples.put(column, row, at.z, colour, is_back);
}

Colour mixed(const Colour& a, const Colour& b, double share) {
  return {a.red + share * (b.red - a.red), a.green + share * (b.green - a.green),
          a.blue + share * (b.blue - a.blue)};
}

Colour colour_of(const Rgb& rgb) {
  return {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])};
}

Rgb rgb_of(const Colour& colour) {
  const auto channel = [](double value) { return static_cast<std::uint8_t>(std::lround(value)); };
  return {channel(colour.red), channel(colour.green), channel(colour.blue)};
}

/// Of the patch of a hole.
Colour patch_colour(std::int32_t hole, const PictureOptions& options) {
  const auto id = static_cast<std::size_t>(hole);
  const double confidence = id <= options.confidence.size() ? options.confidence[id - 1] : 1.0;
  return mixed(kDoubt, colour_of(options.patch_color), confidence);
}

}  // namespace

std::vector<LegendEntry> surface_legend(const PictureOptions& options, bool has_patches) {
  std::vector<LegendEntry> entries = {{rgb_of(kFront), rgb_of(kFront), "surface from the scan"}};
  if (!has_patches) return entries;
  if (options.confidence.empty())
    entries.push_back({options.patch_color, options.patch_color, "filled hole"});
  else
    entries.push_back({rgb_of(kDoubt), options.patch_color, "filled hole, confidence 0 to 1"});
  return entries;
}

std::vector<LegendEntry> share_legend(const std::string& large) {
  if (large.empty()) return {{rgb_of(kFront), rgb_of(kFront), "0 everywhere"}};
  return {{rgb_of(kFront), rgb_of(kLarge), "0 to " + large}};
}

/// Draws one triangle; its colour is found when its first sample shows.
class MeshPicture::TrianglePainter {
 public:
  explicit TrianglePainter(MeshPicture& picture)
      : view_(*picture.view_),
        samples_(*picture.samples_),
        culls_backs_(picture.culls_backs_),
        draws_specks_(picture.draws_specks_) {}

  /// `front`: a function of nothing, the colour of the triangle's front.
  template <class Front>
  void draw(const Corners& corners, const Front& front) {
    const Projected a = view_.project(corners[0]), b = view_.project(corners[1]),
                    c = view_.project(corners[2]);
    if (!a.is_finite() || !b.is_finite() || !c.is_finite()) return;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (draws_specks_) return draw_speck(corners, front, area);
    const SampleRange columns(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}),
                              samples_.width());
    const SampleRange rows(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), samples_.height());
    // Most triangles of a large mesh lie between the samples and end here.
    if (columns.first > columns.last || rows.first > rows.last) return;
    if (!std::isfinite(area) || area == 0.0) return;
    // y points down, so counter-clockwise has a negative area.
    const bool is_front = area < 0.0;
    if (culls_backs_ && !is_front) return;
    std::optional<std::uint32_t> colour;
    for (int row = rows.first; row <= rows.last; ++row) {
      const double y = row + 0.5;
      RowSpan span(columns, y);
      span.reach(a, b);
      span.reach(b, c);
      span.reach(c, a);
      for (int column = span.first(); column <= span.last(); ++column) {
        const double x = column + 0.5;
        const double u = edge_side(b, c, x, y) / area, v = edge_side(c, a, x, y) / area,
                     w = edge_side(a, b, x, y) / area;
        if (u < 0.0 || v < 0.0 || w < 0.0) continue;
        const double depth = u * a.z + v * b.z + w * c.z;
        if (samples_.hides(column, row, depth)) continue;
        if (!colour) colour = shade(corners, is_front ? front() : kBack, is_front);
        samples_.put(column, row, depth, *colour, !is_front);
      }
    }
  }

 private:
  /// A dot at the middle.
  template <class Front>
  void draw_speck(const Corners& corners, const Front& front, double area) {
    const bool is_front = !(area > 0.0);
    if (culls_backs_ && !is_front) return;
    const Vec3 middle = (1.0 / 3.0) * (corners[0] + corners[1] + corners[2]);
    put_dot(view_.project(middle), shade(corners, is_front ? front() : kBack, is_front), !is_front,
            samples_);
  }

  std::uint32_t shade(const Corners& corners, Colour colour, bool is_front) const {
    const Vec3 normal = normalized(cross(corners[1] - corners[0], corners[2] - corners[0]));
    return packed(colour, view_.light(is_front ? normal : -normal));
  }

  const View& view_;
  PictureSamples& samples_;
  bool culls_backs_;
  bool draws_specks_;
};

MeshPicture::MeshPicture(const Box& bounds, const PictureOptions& options)
    : bounds_(bounds), options_(options) {
  const auto fits = [](int size) { return size >= 1 && size <= kLargestSize; };
  if (!fits(options.width) || !fits(options.height))
    throw std::invalid_argument("a picture has 1 to 16384 pixels a side");
  view_ = std::make_unique<View>(bounds, options);
  samples_ = std::make_unique<PictureSamples>(kSamplesPerAxis * options.width,
                                              kSamplesPerAxis * options.height);
}

MeshPicture::~MeshPicture() = default;
MeshPicture::MeshPicture(MeshPicture&&) noexcept = default;
MeshPicture& MeshPicture::operator=(MeshPicture&&) noexcept = default;

void MeshPicture::draw(std::span<const Corners> triangles, std::span<const std::int32_t> hole) {
  TrianglePainter painter(*this);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const std::int32_t id = hole.empty() ? 0 : hole[i];
    painter.draw(triangles[i], [&] { return id > 0 ? patch_colour(id, options_) : kFront; });
  }
}

void MeshPicture::draw_shares(std::span<const Corners> triangles, std::span<const float> shares) {
  TrianglePainter painter(*this);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    painter.draw(triangles[i], [&] { return mixed(kFront, kLarge, shares[i]); });
}

void MeshPicture::draw_colored(std::span<const Corners> triangles, std::span<const Rgb> fronts) {
  TrianglePainter painter(*this);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    painter.draw(triangles[i], [&] { return colour_of(fronts[i]); });
}

void MeshPicture::draw_points(std::span<const Vec3> points, std::span<const Vec3> normals) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Projected at = view_->project(points[i]);
    if (!at.is_finite()) continue;
    const Vec3 normal = normals.empty() ? view_->eye : normalized(normals[i]);
    const bool is_front = dot(normal, view_->eye) >= 0.0;
    if (culls_backs_ && !is_front) continue;
    const std::uint32_t colour =
        packed(is_front ? kFront : kBack, view_->light(is_front ? normal : -normal));
    put_dot(at, colour, !is_front, *samples_);
  }
}

bool MeshPicture::shows_backs() const { return share_of_backs() > kMostlyBacks; }

double MeshPicture::share_of_backs() const { return samples_->share_of_backs(); }

void MeshPicture::look(double azimuth_deg, bool from_below) {
  options_.azimuth_deg = azimuth_deg;
  is_from_below_ = from_below;
  view_ = std::make_unique<View>(bounds_, options_, is_from_below_);
  samples_->clear();
}

void MeshPicture::turn(double degrees) {
  look(std::fmod(options_.azimuth_deg + degrees, 360.0), is_from_below_);
}

void MeshPicture::look_at_fronts(bool may_be_interior, const std::function<void()>& draw) {
  constexpr double kMany = 0.35, kHalf = 0.5;  // leaves of trees have half
  struct Side {
    double degrees;
    bool from_below;
    double more_backs_than;  ///< from all sides before: then the side is worth a drawing
  };
  constexpr std::array<Side, 5> kSides = {{{0.0, false, 0.0},
                                           {180.0, false, kMany},
                                           {90.0, false, kHalf},
                                           {270.0, false, kHalf},
                                           {0.0, true, kMostlyBacks}}};
  const double usual = options_.azimuth_deg;
  double least = share_of_backs();
  std::size_t best = 0, now = 0;
  const auto look_from = [&](std::size_t side) {
    look(usual + kSides[side].degrees, kSides[side].from_below);
    draw();
    now = side;
  };
  for (std::size_t side = 1; side < kSides.size(); ++side) {
    if (least <= kSides[side].more_backs_than) break;
    look_from(side);
    if (may_be_interior && side == 1 && shows_backs()) {
      leave_out_backs();
      return look_from(0);
    }
    if (share_of_backs() >= least) continue;
    least = share_of_backs();
    best = side;
  }
  if (best != now) look_from(best);
}

void MeshPicture::show_specks(const std::function<void()>& draw) {
  if (!samples_->is_empty()) return;
  draws_specks_ = true;
  draw();
  draws_specks_ = false;
}

void MeshPicture::leave_out_backs() {
  culls_backs_ = true;
  samples_->clear();
}

std::vector<std::uint8_t> MeshPicture::pixels() const {
  std::vector<std::uint8_t> pixels =
      resolve_pixels(*samples_, options_.shade_creases ? view_->samples_per_unit : 0.0);
  if (legend_.empty()) return pixels;
  constexpr double kSeen = 0.001;  // share of what is drawn
  std::vector<LegendEntry> entries = legend_;
  if (samples_->share_of_backs() > kSeen)
    entries.push_back({rgb_of(kBack), rgb_of(kBack), "back face"});
  draw_legend(entries, options_.width, options_.height, pixels);
  return pixels;
}

void MeshPicture::write_png(const std::filesystem::path& path) const {
  write_rgb_png(path, options_.width, options_.height, pixels());
}

}  // namespace orbweave
