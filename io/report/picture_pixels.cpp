#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/error.h"
#include "io/report/picture_samples.h"
#include "io/system/atomic_file.h"

namespace orbweave {
namespace {

constexpr Colour kBackground{250.0, 250.0, 252.0};

struct Offset {
  int x, y;
  double length = std::hypot(x, y);
};
/// Half of the neighbours that a sample is compared with; the others lie opposite. Several
/// distances, so that both fine and broad creases show.
const std::array<Offset, 10> kOffsets = {
    {{3, 0}, {0, 3}, {4, 4}, {4, -4}, {9, 3}, {-3, 9}, {16, 6}, {-6, 16}, {14, 14}, {-14, 14}}};
constexpr double kDarkest = 0.55;

/// How far the middle between two opposite neighbours lies in front of a sample, relative to
/// their distance; at most 1, and 0 where either is background.
double hollowness(const PictureSamples& samples, int x, int y, const Offset& offset,
                  double samples_per_unit) {
  const int x1 = x + offset.x, y1 = y + offset.y, x2 = x - offset.x, y2 = y - offset.y;
  if (!samples.contains(x1, y1) || !samples.contains(x2, y2)) return 0.0;
  if (!samples.is_drawn(x1, y1) || !samples.is_drawn(x2, y2)) return 0.0;
  const double own = samples.depth(x, y);
  const double ahead = 0.5 * (samples.depth(x1, y1) + samples.depth(x2, y2)) - own;
  return std::clamp(ahead * samples_per_unit / offset.length, 0.0, 1.0);
}

double crease_light(const PictureSamples& samples, int x, int y, double samples_per_unit) {
  double sum = 0.0;
  for (const Offset& offset : kOffsets) sum += hollowness(samples, x, y, offset, samples_per_unit);
  return 1.0 - (1.0 - kDarkest) * std::min(1.0, 2.0 * sum / kOffsets.size());
}

Colour sample_colour(const PictureSamples& samples, int x, int y, double samples_per_unit) {
  if (!samples.is_drawn(x, y)) return kBackground;
  const Colour colour = samples.colour(x, y);
  if (samples_per_unit <= 0.0) return colour;
  const double light = crease_light(samples, x, y, samples_per_unit);
  return {colour.red * light, colour.green * light, colour.blue * light};
}

std::uint8_t channel(double sum) {
  return static_cast<std::uint8_t>(std::lround(sum / (kSamplesPerAxis * kSamplesPerAxis)));
}

void append_pixel(const PictureSamples& samples, int column, int row, double samples_per_unit,
                  std::vector<std::uint8_t>& pixels) {
  Colour sum;
  for (int y = kSamplesPerAxis * row; y < kSamplesPerAxis * (row + 1); ++y) {
    for (int x = kSamplesPerAxis * column; x < kSamplesPerAxis * (column + 1); ++x) {
      const Colour colour = sample_colour(samples, x, y, samples_per_unit);
      sum = {sum.red + colour.red, sum.green + colour.green, sum.blue + colour.blue};
    }
  }
  for (const double value : {sum.red, sum.green, sum.blue}) pixels.push_back(channel(value));
}

/// In memory first: an error of the file must not travel through the C library.
std::vector<std::byte> encoded_png(int width, int height, const std::vector<std::uint8_t>& pixels,
                                   const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    throw_resource("cannot encode the picture", {.file = path.string(), .found = image.message});
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> resolve_pixels(const PictureSamples& samples, double samples_per_unit) {
  const int width = samples.width() / kSamplesPerAxis, height = samples.height() / kSamplesPerAxis;
  std::vector<std::uint8_t> pixels;
  pixels.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column)
      append_pixel(samples, column, row, samples_per_unit, pixels);
  return pixels;
}

void write_rgb_png(const std::filesystem::path& path, int width, int height,
                   const std::vector<std::uint8_t>& pixels) {
  const std::vector<std::byte> bytes = encoded_png(width, height, pixels, path);
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

}  // namespace orbweave
