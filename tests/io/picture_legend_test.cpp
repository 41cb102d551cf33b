// What the colours of a picture are, and the words that say so.
#include "io/report/picture_legend.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "io/report/picture.h"
#include "io/report/picture_palette.h"
#include "io/report/point_colors.h"
#include "io/report/small_font.h"

namespace orbweave {
namespace {

int ink_of(char character) {
  int ink = 0;
  for (int y = 0; y < kGlyphHeight; ++y)
    for (int x = 0; x < kGlyphWidth; ++x) ink += has_ink(character, x, y) ? 1 : 0;
  return ink;
}

/// Rows of a cloud without positions that matter.
template <class Value>
PointCloud points_with(const std::vector<std::string>& names, ScalarType type,
                       const std::vector<Value>& values) {
  PointCloud cloud;
  for (const std::string& name : names) cloud.schema.attributes.push_back({name, type});
  cloud.positions.resize(values.size() / names.size());
  cloud.attributes.resize(values.size() * sizeof(Value));
  std::memcpy(cloud.attributes.data(), values.data(), cloud.attributes.size());
  return cloud;
}

template <class Value>
std::vector<Rgb> colors_of(const std::vector<std::string>& names, ScalarType type,
                           const std::vector<Value>& values) {
  const PointCloud cloud = points_with(names, type, values);
  PointColors colors(cloud.schema);
  if (colors.needs_survey()) colors.survey(cloud);
  colors.finish();
  std::vector<Rgb> found;
  for (std::size_t i = 0; i < cloud.size(); ++i) found.push_back(colors.of(cloud, i));
  return found;
}

const std::vector<std::string> kRgb = {"red", "green", "blue"};

TEST_CASE("ALegendOfSharesThatAreAll0ShowsOneColor") {
  const std::vector<LegendEntry> none = share_legend("");
  REQUIRE(none.size() == 1);
  CHECK(none[0].text == "0 everywhere");
  CHECK(none[0].first == none[0].last);
  CHECK(share_legend("2.5 and more")[0].text == "0 to 2.5 and more");
}

TEST_CASE("EveryCharacterOfALegendIsDrawnAndNoTwoAlike") {
  const std::string drawn = "abcdefghijklmnopqrstuvwxyz0123456789.,:()-+=/%";
  for (const char character : drawn) {
    CAPTURE(character);
    CHECK(ink_of(character) >= 3);
    for (const char other : drawn) {
      bool alike = character != other;
      for (int y = 0; y < kGlyphHeight; ++y)
        for (int x = 0; x < kGlyphWidth; ++x)
          alike = alike && has_ink(character, x, y) == has_ink(other, x, y);
      CHECK_FALSE(alike);
    }
  }
  CHECK(ink_of(' ') == 0);
  CHECK(ink_of('\n') == 0);
  CHECK(ink_of('A') == ink_of('a'));
}

TEST_CASE("ALegendTakesTheCornerAndLeavesTheRestAsItWas") {
  constexpr int kWidth = 600, kHeight = 450;
  std::vector<std::uint8_t> pixels(3 * kWidth * kHeight, 100);
  draw_legend({{{255, 0, 0}, {0, 0, 255}, "from red to blue"}}, kWidth, kHeight, pixels);
  const auto at = [&](int x, int y, int channel) {
    return pixels[3 * static_cast<std::size_t>(y * kWidth + x) + static_cast<std::size_t>(channel)];
  };
  CHECK(at(0, 0, 0) == 100);
  CHECK(at(300, 10, 0) == 100);
  CHECK(at(20, 40, 0) == 100);
  CHECK(at(8, 8, 0) == 255);  // the swatch begins red and ends blue
  CHECK(at(8, 8, 2) == 0);
  CHECK(at(25, 8, 0) == 0);
  CHECK(at(25, 8, 2) == 255);
  int dark = 0;
  for (int x = 30; x < 140; ++x)
    for (int y = 8; y < 17; ++y) dark += at(x, y, 0) < 60 ? 1 : 0;
  CHECK(dark > 100);
}

TEST_CASE("ALegendThatFindsNoRoomIsLeftOut") {
  const std::vector<LegendEntry> entries(50, {{1, 2, 3}, {1, 2, 3}, std::string(300, 'x')});
  for (const int size : {1, 2, 9, 20, 33, 60, 200}) {
    CAPTURE(size);
    const auto pixel_count = static_cast<std::size_t>(size * size);
    std::vector<std::uint8_t> pixels(3 * pixel_count, 7);
    draw_legend(entries, size, size, pixels);
    CHECK(pixels.size() == 3 * pixel_count);
    if (size < 20) CHECK(std::ranges::count(pixels, 7) == std::ssize(pixels));
  }
}

TEST_CASE("NamedComponentsHaveColoursThatAreToldApart") {
  for (std::size_t a = 0; a < kNamedComponents; ++a)
    for (std::size_t b = 0; b < a; ++b) {
      double squares = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double apart = double{component_color(a)[c] + 0.0} - component_color(b)[c];
        squares += apart * apart;
      }
      CAPTURE(a, b);
      CHECK(std::sqrt(squares) > 40.0);
    }
  CHECK(component_color(11) != component_color(12));
  CHECK(component_color(1'000'000) == component_color(1'000'000));
}

TEST_CASE("TheLegendOfComponentsNamesTheLargestAndCountsTheRest") {
  std::vector<std::uint64_t> triangles(kNamedComponents + 3, 1);
  triangles[0] = 12'345;
  const std::vector<LegendEntry> entries = component_legend(triangles);
  REQUIRE(entries.size() == kNamedComponents + 1);
  CHECK(entries[0].text == "component of 12,345 triangles");
  CHECK(entries[0].first == component_color(0));
  CHECK(entries[1].text == "component of 1 triangle");
  CHECK(entries.back().text == "3 smaller components in paler colours");
  CHECK(component_legend(std::vector<std::uint64_t>{5}).size() == 1);
}

TEST_CASE("ColoursOfEveryWidthAreThoseOfTheScan") {
  CHECK(colors_of<std::uint8_t>(kRgb, ScalarType::kUint8, {1, 2, 255}) ==
        std::vector<Rgb>{{1, 2, 255}});
  CHECK(colors_of<std::uint16_t>(kRgb, ScalarType::kUint16, {0, 257 * 9, 65535, 257, 514, 771}) ==
        std::vector<Rgb>{{0, 9, 255}, {1, 2, 3}});
  CHECK(colors_of<std::uint16_t>(kRgb, ScalarType::kUint16, {1, 2, 255}) ==
        std::vector<Rgb>{{1, 2, 255}});
  CHECK(colors_of<float>({"Red", "Green", "Blue"}, ScalarType::kFloat32, {0.0F, 0.5F, 1.0F}) ==
        std::vector<Rgb>{{0, 128, 255}});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(colors_of<float>(kRgb, ScalarType::kFloat32, {-3.0F, 20.0F, nan})[0][1] == 20);
}

TEST_CASE("AnIntensityIsGreyFromItsLowToItsHighValuesWhateverTheirOrder") {
  std::vector<float> values;
  for (int i = 0; i <= 1000; ++i) values.push_back(static_cast<float>(200 + i));
  values.push_back(1e9F);  // a mirror
  values.push_back(std::numeric_limits<float>::infinity());
  const auto greys = colors_of<float>({"intensity"}, ScalarType::kFloat32, values);
  CHECK(greys[0][0] == 30);
  CHECK(greys.back()[0] == 245);
  CHECK(greys[1000][0] == 245);
  CHECK(greys[500][0] > greys[250][0]);
  CHECK(greys[500] == Rgb{greys[500][0], greys[500][0], greys[500][0]});
  std::vector<float> reversed(values.rbegin(), values.rend());
  auto turned = colors_of<float>({"intensity"}, ScalarType::kFloat32, reversed);
  std::ranges::reverse(turned);
  CHECK(turned == greys);
  CHECK(colors_of<float>({"intensity"}, ScalarType::kFloat32, {4.0F, 4.0F}).size() == 2);
}

TEST_CASE("PointsWithoutColoursSaySo") {
  CHECK_FALSE(PointColors(PointSchema{}).any());
  PointSchema half;
  half.attributes = {{"red", ScalarType::kUint8}, {"green", ScalarType::kUint8}};
  CHECK_FALSE(PointColors(half).any());
  half.attributes.push_back({"intensity", ScalarType::kUint16});
  CHECK(PointColors(half).any());
  CHECK_THAT(PointColors(half).legend().text, Catch::Contains("intensity"));
}

TEST_CASE("TheLegendNamesWhatIsInThePicture") {
  PictureOptions options;
  CHECK(surface_legend(options, false).size() == 1);
  CHECK(surface_legend(options, true).back().text == "filled hole");
  CHECK(surface_legend(options, true).back().first == options.patch_color);
  options.confidence = {0.5F};
  CHECK(surface_legend(options, true).back().text == "filled hole, confidence 0 to 1");
}

TEST_CASE("BackFacesAreNamedWhereSomeAreSeen") {
  const std::vector<std::array<Vec3, 3>> front = {{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}}};
  const std::vector<std::array<Vec3, 3>> back = {{{{1, -1, 0}, {-1, -1, 0}, {0, 1, 0}}}};
  const auto lines = [](const std::vector<std::array<Vec3, 3>>& triangles) {
    PictureOptions options{.width = 600, .height = 400, .up = UpAxis::kY, .azimuth_deg = 0.0};
    options.elevation_deg = 0.0;
    MeshPicture picture({{-1, -1, 0}, {1, 1, 0}}, options);
    picture.draw_colored(triangles, std::vector<Rgb>{{0, 200, 0}});
    picture.set_legend({{{0, 200, 0}, {0, 200, 0}, "front"}});
    const auto pixels = picture.pixels();
    const auto is_red = [&](int x, int y) {
      const std::size_t at = 3 * static_cast<std::size_t>(y * 600 + x);
      return pixels[at] > 150 && pixels[at + 1] < 100;
    };
    const std::size_t middle = 3 * std::size_t{200 * 600 + 300};
    const bool green = pixels[middle + 1] > 100 && pixels[middle] < 20;
    return std::pair(is_red(12, 22), green);
  };
  CHECK(lines(front) == std::pair(false, true));
  CHECK(lines(back) == std::pair(true, false));
}

}  // namespace
}  // namespace orbweave
