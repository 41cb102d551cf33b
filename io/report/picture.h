// Pictures of meshes and clouds: a small software rasteriser that takes triangles in any order.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/box.h"
#include "io/job/job.h"
#include "io/report/picture_legend.h"
#include "io/vec3.h"

namespace orbweave {

class PictureSamples;

struct PictureOptions {
  int width = 1200;           ///< pixels, 1 to 16384
  int height = 900;           ///< pixels, 1 to 16384
  UpAxis up = UpAxis::kAuto;  ///< kAuto: +z for what is low in z, else +y
  double azimuth_deg = 30.0;  ///< the eye's angle about the up axis; 0 looks at the front
  std::optional<double> elevation_deg = {};  ///< the eye's angle above the horizon; empty: 20, or
                                             ///< 40 for what is flat along the up axis
  bool shade_creases = true;                 ///< darken what lies behind its surroundings
  Rgb patch_color = {0x80, 0xa8, 0xe2};      ///< of filled holes
  /// By id of a hole, from 1 on, the confidence of its patch, from 0 to 1: patches are drawn from
  /// orange (0) to patch_color (1). Empty: all in patch_color.
  std::vector<float> confidence{};
};

/// What the colours of draw() mean.
std::vector<LegendEntry> surface_legend(const PictureOptions& options, bool has_patches);
/// What the colours of draw_shares() mean; `large`: in words, what 1 stands for; empty: all shares
/// are 0.
std::vector<LegendEntry> share_legend(const std::string& large);

/// The axis that is upright, 0 to 2: the one that is wanted; of kAuto that of the shape, z where it
/// is less than half as high in z as it is wide in x and in y, else y.
int upright_axis(UpAxis wanted, const Box& bounds);

/// Parallel projection of what `bounds` holds, fitted to the picture. Front faces
/// (counter-clockwise) are light and warm, back faces red, faces of filled holes blue (or as asked
/// for); so the red inside shows through a hole. Memory is 8 bytes per sample, 4 samples per pixel,
/// whatever is drawn. The picture does not depend on the order of drawing.
class MeshPicture {
 public:
  /// Throws std::invalid_argument for a size out of range.
  explicit MeshPicture(const Box& bounds, const PictureOptions& options = {});
  ~MeshPicture();
  MeshPicture(MeshPicture&&) noexcept;
  MeshPicture& operator=(MeshPicture&&) noexcept;

  /// Draws triangles, world units. `hole` is empty or has one id per triangle (0: scanned
  /// surface). May be called from several threads at a time.
  void draw(std::span<const std::array<Vec3, 3>> triangles,
            std::span<const std::int32_t> hole = {});
  /// Of what is drawn, the share of back faces, 0 to 1; 0 where nothing is.
  double share_of_backs() const;
  /// Whether most of what is drawn are back faces, as of a room that is seen from outside.
  bool shows_backs() const;
  /// Starts over, with the eye so far further around the up axis.
  void turn(double degrees);
  /// Once draw() has drawn all: draws again from other sides where too much of what is drawn are
  /// back faces, and keeps the side with the fewest. From the opposite side a front that was
  /// scanned from there alone shows, from below a ceiling. What `may_be_interior` and shows its
  /// backs from the opposite side, too, is seen without back faces.
  void look_at_fronts(bool may_be_interior, const std::function<void()>& draw);
  /// Once draw() has drawn all: where nothing shows, since every triangle is smaller than a sample
  /// and lies between these, draws again with a dot for each.
  void show_specks(const std::function<void()>& draw);
  /// Starts over, without back faces from now on: one looks through walls at what faces the eye.
  void leave_out_backs();
  /// Draws triangles in colours that tell a number each: 0 is that of the surface, 1 purple.
  void draw_shares(std::span<const std::array<Vec3, 3>> triangles, std::span<const float> shares);
  /// Draws triangles whose fronts have a colour each.
  void draw_colored(std::span<const std::array<Vec3, 3>> triangles, std::span<const Rgb> fronts);
  /// Draws points as dots of a pixel or two; `normals` is empty or has one per point and shades
  /// them. May be called from several threads at a time.
  void draw_points(std::span<const Vec3> points, std::span<const Vec3> normals = {});

  /// What the colours mean, to be written into the picture; back faces get a line of their own
  /// where some are seen.
  void set_legend(std::vector<LegendEntry> entries) { legend_ = std::move(entries); }

  int width() const { return options_.width; }
  int height() const { return options_.height; }
  /// 3 bytes (red, green, blue) per pixel, row by row from the top; the legend among them.
  std::vector<std::uint8_t> pixels() const;
  /// Writes a PNG, whole or not at all. Throws Error (resource) where it cannot be written.
  void write_png(const std::filesystem::path& path) const;

 private:
  struct View;
  class TrianglePainter;
  void look(double azimuth_deg, bool from_below);
  Box bounds_;
  PictureOptions options_;
  bool culls_backs_ = false;
  bool draws_specks_ = false;   ///< triangles are dots
  bool is_from_below_ = false;  ///< the eye is as far below the horizon as it would be above
  std::vector<LegendEntry> legend_;
  std::unique_ptr<View> view_;
  std::unique_ptr<PictureSamples> samples_;
};

}  // namespace orbweave
