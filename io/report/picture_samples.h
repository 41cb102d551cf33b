// What a picture is made of before it is pixels.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace orbweave {

inline constexpr int kSamplesPerAxis = 2;  ///< of a pixel

/// 0 to 255 per channel.
struct Colour {
  double red = 0.0, green = 0.0, blue = 0.0;
};

/// An unsigned number that orders as the depth does. Nearer is larger.
inline std::uint32_t depth_key(float depth) {
  const auto bits = std::bit_cast<std::uint32_t>(depth);
  return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}
inline float depth_of(std::uint32_t key) {
  return std::bit_cast<float>(key & 0x80000000u ? key & 0x7fffffffu : ~key);
}

/// Depth and colour per sample in one word, depth above: the larger word is in front, and among
/// equal depths the colour decides, never who came first.
class PictureSamples {
 public:
  PictureSamples(int width, int height)
      : width_(width),
        height_(height),
        words_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

  int width() const { return width_; }
  int height() const { return height_; }

  void put(int x, int y, double depth, std::uint32_t colour, bool is_back) {
    const std::uint64_t word = std::uint64_t{depth_key(static_cast<float>(depth))} << 32 | kDrawn |
                               (is_back ? kBackFace : 0) | colour;
    std::atomic_ref<std::uint64_t> stored(words_[index(x, y)]);
    std::uint64_t seen = stored.load(std::memory_order_relaxed);
    while (seen < word && !stored.compare_exchange_weak(seen, word, std::memory_order_relaxed)) {
    }
  }
  /// True when nothing at this depth could show.
  bool hides(int x, int y, double depth) const {
    std::atomic_ref<std::uint64_t> stored(const_cast<std::uint64_t&>(words_[index(x, y)]));
    return (stored.load(std::memory_order_relaxed) >> 32) > depth_key(static_cast<float>(depth));
  }
  bool is_drawn(int x, int y) const { return words_[index(x, y)] != 0; }
  float depth(int x, int y) const {
    return depth_of(static_cast<std::uint32_t>(words_[index(x, y)] >> 32));
  }
  Colour colour(int x, int y) const {
    const std::uint64_t word = words_[index(x, y)];
    return {static_cast<double>(word >> 16 & 255), static_cast<double>(word >> 8 & 255),
            static_cast<double>(word & 255)};
  }
  /// Of the samples that are drawn.
  double share_of_backs() const {
    std::size_t drawn = 0, backs = 0;
    for (const std::uint64_t word : words_) {
      drawn += word != 0 ? 1 : 0;
      backs += (word & kBackFace) != 0 ? 1 : 0;
    }
    return drawn == 0 ? 0.0 : static_cast<double>(backs) / static_cast<double>(drawn);
  }
  bool is_empty() const {
    return std::ranges::all_of(words_, [](std::uint64_t word) { return word == 0; });
  }
  void clear() { words_.assign(words_.size(), 0); }
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

 private:
  static constexpr std::uint64_t kDrawn = 0x01000000u, kBackFace = 0x02000000u;

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_, height_;
  std::vector<std::uint64_t> words_;
};

/// Averages the samples of each pixel, over a light background: 3 bytes per pixel, row by row.
/// With `samples_per_unit` above 0 it first darkens creases: samples behind the middle of opposite
/// neighbours, distances compared with depths at that scale.
std::vector<std::uint8_t> resolve_pixels(const PictureSamples& samples, double samples_per_unit);

/// Writes 3 bytes per pixel as a PNG, whole or not at all. Throws Error (resource).
void write_rgb_png(const std::filesystem::path& path, int width, int height,
                   const std::vector<std::uint8_t>& pixels);

}  // namespace orbweave
