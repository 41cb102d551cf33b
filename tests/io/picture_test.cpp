#include "io/report/picture.h"

#include <png.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <thread>
#include <utility>

#include "io/error.h"
#include "io/job/job.h"
#include "io/report/picture_up.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Corners = std::array<Vec3, 3>;

/// A sphere about `center`, outside counter-clockwise; triangles whose centre `keep` refuses are
/// left out.
template <class Keep>
std::vector<Corners> sphere(Vec3 center, double radius, int rings, Keep keep) {
  const auto vertex = [&](int ring, int spoke) {
    const double polar = std::numbers::pi * ring / rings;
    const double around = std::numbers::pi * spoke / rings;
    const Vec3 direction{std::sin(polar) * std::cos(around), std::cos(polar),
                         std::sin(polar) * std::sin(around)};
    return center + radius * direction;
  };
  std::vector<Corners> triangles;
  const auto add = [&](Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 middle = (a + b + c) / 3.0 - center;
    if (squared_norm(cross(b - a, c - a)) > 1e-20 * radius && keep(middle))
      triangles.push_back({a, b, c});
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int spoke = 0; spoke < 2 * rings; ++spoke) {
      const Vec3 a = vertex(ring, spoke), b = vertex(ring, spoke + 1),
                 c = vertex(ring + 1, spoke + 1), d = vertex(ring + 1, spoke);
      add(a, b, c);
      add(a, c, d);
    }
  }
  return triangles;
}

std::vector<Corners> sphere(int rings) {
  return sphere({}, 1.0, rings, [](Vec3) { return true; });
}

Box bounds_of(const std::vector<Corners>& triangles) {
  Box box;
  for (const Corners& corners : triangles)
    for (const Vec3 corner : corners) box.extend(corner);
  return box;
}

struct Pixel {
  int red, green, blue;
};

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> bytes;
  Pixel at(int x, int y) const {
    const std::uint8_t* pixel = bytes.data() + 3 * (y * width + x);
    return {pixel[0], pixel[1], pixel[2]};
  }
};

Image decoded(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()) != 0);
  image.format = PNG_FORMAT_RGB;
  Image result{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  result.bytes.resize(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, result.bytes.data(), 0, nullptr) != 0);
  return result;
}

bool is_background(Pixel p) { return p.red > 245 && p.green > 245 && p.blue > 245; }
bool is_front(Pixel p) { return !is_background(p) && p.red >= p.blue && p.red < p.blue + 40; }
bool is_back(Pixel p) { return p.red > p.green + 40 && p.red > p.blue + 40; }
bool is_hole(Pixel p) { return p.blue > p.red + 30; }

constexpr PictureOptions kSmall{.width = 200, .height = 150};

/// Towards the eye of the default view.
const Vec3 kEye{std::sin(std::numbers::pi / 6.0) * std::cos(std::numbers::pi / 9.0),
                std::sin(std::numbers::pi / 9.0),
                std::cos(std::numbers::pi / 6.0) * std::cos(std::numbers::pi / 9.0)};

TEST_CASE("SurfacesThatAreSmallerThanAPixelShowAsDots") {
  const double size = 1e-3, apart = 1000.0;
  std::vector<Corners> triangles = sphere({}, size, 4, [](Vec3) { return true; });
  for (const Corners& corners : sphere({apart, 0, 0}, size, 4, [](Vec3) { return true; }))
    triangles.push_back(corners);
  MeshPicture picture(bounds_of(triangles));
  const std::vector<std::uint8_t> nothing = picture.pixels();
  const auto draw = [&] { picture.draw(triangles); };
  draw();
  REQUIRE(picture.pixels() == nothing);
  picture.show_specks(draw);
  const std::vector<std::uint8_t> dots = picture.pixels();
  std::vector<int> columns;
  for (std::size_t i = 0; i < dots.size(); ++i)
    if (dots[i] != nothing[i]) columns.push_back(static_cast<int>(i / 3) % picture.width());
  REQUIRE_FALSE(columns.empty());
  CHECK(columns.size() < 200);
  const auto [left, right] = std::ranges::minmax(columns);
  CHECK(left < picture.width() / 4);
  CHECK(right > picture.width() * 3 / 4);
}

TEST_CASE("WhatShowsAnywayGetsNoDots") {
  const std::vector<Corners> triangles = sphere(20);
  MeshPicture picture(bounds_of(triangles));
  const auto draw = [&] { picture.draw(triangles); };
  draw();
  const std::vector<std::uint8_t> before = picture.pixels();
  picture.show_specks(draw);
  CHECK(picture.pixels() == before);
}

TEST_CASE("AClosedSphereShowsItsFrontAndTheBackgroundAroundIt") {
  const std::vector<Corners> triangles = sphere(24);
  MeshPicture picture(bounds_of(triangles), kSmall);
  picture.draw(triangles);
  const test::ScratchDirectory scratch;
  picture.write_png(scratch / "sphere.png");
  const Image image = decoded(scratch / "sphere.png");
  REQUIRE(image.width == 200);
  REQUIRE(image.height == 150);
  CHECK(is_front(image.at(100, 75)));
  for (const int x : {0, 199})
    for (const int y : {0, 149}) CHECK(is_background(image.at(x, y)));
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) CHECK_FALSE(is_back(image.at(x, y)));
}

TEST_CASE("ThePictureIsFilledAndNotCut") {
  const std::vector<Corners> triangles = sphere(24);
  MeshPicture picture(bounds_of(triangles), kSmall);
  picture.draw(triangles);
  const Image image{200, 150, picture.pixels()};
  int drawn = 0;
  for (int y = 0; y < 150; ++y)
    for (int x = 0; x < 200; ++x) {
      const bool foreground = !is_background(image.at(x, y));
      drawn += foreground;
      if (x == 0 || y == 0 || x == 199 || y == 149) CHECK_FALSE(foreground);
    }
  // The box around a sphere is larger than the sphere, but not by that much.
  CHECK(drawn > 200 * 150 / 8);
}

TEST_CASE("AHoleShowsTheBackOfTheSurfaceBehindIt") {
  const auto open = sphere({}, 1.0, 48, [](Vec3 middle) { return dot(middle, kEye) < 0.9; });
  MeshPicture picture(bounds_of(open), kSmall);
  picture.draw(open);
  const Image image{200, 150, picture.pixels()};
  CHECK(is_back(image.at(100, 75)));
  CHECK(is_front(image.at(100, 75 + 35)));
}

TEST_CASE("AFilledHoleIsTinted") {
  const std::vector<Corners> triangles = sphere(24);
  std::vector<std::int32_t> hole(triangles.size(), 0);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    hole[i] = dot(triangles[i][0], kEye) > 0.8 ? 7 : 0;
  MeshPicture picture(bounds_of(triangles), kSmall);
  picture.draw(triangles, hole);
  const Image image{200, 150, picture.pixels()};
  CHECK(is_hole(image.at(100, 75)));
  CHECK(is_front(image.at(100, 75 + 45)));
}

TEST_CASE("FilledHolesHaveTheColourThatWasAskedFor") {
  const std::vector<Corners> triangles = sphere(24);
  const std::vector<std::int32_t> hole(triangles.size(), 1);
  PictureOptions options = kSmall;
  options.patch_color = {0, 200, 0};
  MeshPicture picture(bounds_of(triangles), options);
  picture.draw(triangles, hole);
  const Pixel middle = Image{200, 150, picture.pixels()}.at(100, 75);
  CHECK(middle.red == 0);
  CHECK(middle.green > 60);
  CHECK(middle.blue == 0);
  PictureOptions usual = kSmall;
  usual.patch_color = Job{}.output.patch_color;
  CHECK(usual.patch_color == kSmall.patch_color);
}

TEST_CASE("DoubtfulPatchesAreDrawnTowardsOrange") {
  const std::vector<Corners> triangles = sphere(24);
  const auto middle_of = [&](std::vector<float> confidence) {
    PictureOptions options = kSmall;
    options.patch_color = {0, 0, 200};
    options.confidence = std::move(confidence);
    MeshPicture picture(bounds_of(triangles), options);
    picture.draw(triangles, std::vector<std::int32_t>(triangles.size(), 2));
    return Image{200, 150, picture.pixels()}.at(100, 75);
  };
  const Pixel sure = middle_of({0.0F, 1.0F}), half = middle_of({0.0F, 0.5F}),
              doubtful = middle_of({1.0F, 0.0F});
  CHECK(sure.red == 0);
  CHECK(half.red > sure.red + 40);
  CHECK(doubtful.red > half.red + 40);
  CHECK(doubtful.blue < 40);
  CHECK(middle_of({}).red == 0);
}

TEST_CASE("BackFacesLeftOutShowTheFarSideFromWithin") {
  std::vector<Corners> inward = sphere(24);
  for (Corners& corners : inward) std::swap(corners[1], corners[2]);
  MeshPicture picture(bounds_of(inward), kSmall);
  picture.draw(inward);
  CHECK(picture.shows_backs());
  const Pixel outside = Image{200, 150, picture.pixels()}.at(100, 75);
  CHECK(outside.red > 2 * outside.blue);  // backs are red
  picture.leave_out_backs();
  picture.draw(inward);
  CHECK_FALSE(picture.shows_backs());
  const Pixel within = Image{200, 150, picture.pixels()}.at(100, 75);
  CHECK(within.red < 2 * within.blue);
  CHECK(within.red < 250);  // and not the background
  MeshPicture usual(bounds_of(inward), kSmall);
  usual.draw(sphere(24));
  CHECK_FALSE(usual.shows_backs());
}

TEST_CASE("APictureIsTurnedAroundAndBack") {
  // The far half of a sphere, as seen from within: its front faces the other side.
  std::vector<Corners> half = sphere(24);
  const double middle = bounds_of(half).center().z;
  std::erase_if(half, [&](const Corners& t) { return t[0].z + t[1].z + t[2].z > 3.0 * middle; });
  PictureOptions options = kSmall;
  options.up = UpAxis::kY;
  MeshPicture picture(bounds_of(half), options);
  picture.draw(half);
  const std::vector<std::uint8_t> from_within = picture.pixels();
  const double backs = picture.share_of_backs();
  CHECK(backs > 0.5);
  picture.turn(180.0);
  picture.draw(half);
  CHECK(picture.share_of_backs() < 0.5 * backs);
  picture.turn(180.0);
  picture.draw(half);
  CHECK(picture.pixels() == from_within);
}

/// An upright wall whose front faces so far around the up axis.
std::vector<Corners> wall(double degrees) {
  const double angle = degrees * std::numbers::pi / 180.0;
  const Vec3 along{std::cos(angle), 0.0, -std::sin(angle)}, up{0.0, 1.0, 0.0};
  const Vec3 corner = -0.5 * along;
  return {{corner, corner + along, corner + along + up},
          {corner, corner + along + up, corner + up}};
}

TEST_CASE("OfFourSidesTheOneThatShowsFewestBacksIsTaken") {
  // The default view is from 30 degrees around the up axis.
  const double degrees = GENERATE(30.0, 210.0, 120.5, 300.5);
  PictureOptions options = kSmall;
  options.up = UpAxis::kY;
  const std::vector<Corners> front = wall(degrees);
  MeshPicture picture(bounds_of(front), options);
  const auto draw = [&] { picture.draw(front); };
  draw();
  picture.look_at_fronts(false, draw);
  CHECK(picture.share_of_backs() == 0.0);
  const std::vector<std::uint8_t> seen = picture.pixels();
  picture.look_at_fronts(false, draw);
  CHECK(picture.pixels() == seen);
}

TEST_CASE("ACeilingIsSeenFromBelow") {
  const std::vector<Corners> ceiling = {{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 0, 1}},
                                        {Vec3{0, 0, 0}, Vec3{1, 0, 1}, Vec3{0, 0, 1}}};
  MeshPicture picture(bounds_of(ceiling), kSmall);
  const auto draw = [&] { picture.draw(ceiling); };
  draw();
  CHECK(picture.share_of_backs() == 1.0);
  picture.look_at_fronts(false, draw);
  CHECK(picture.share_of_backs() == 0.0);
  const Pixel seen = Image{200, 150, picture.pixels()}.at(100, 75);
  CHECK(is_front(seen));
  CHECK(seen.red > 150);  // the light comes from below, too
}

TEST_CASE("WhatShowsAsManyBacksFromEverySideIsSeenFromTheUsualOne") {
  std::vector<Corners> inward = sphere(24);
  for (Corners& corners : inward) std::swap(corners[1], corners[2]);
  MeshPicture picture(bounds_of(inward), kSmall);
  const auto draw = [&] { picture.draw(inward); };
  draw();
  const std::vector<std::uint8_t> usual = picture.pixels();
  picture.look_at_fronts(false, draw);
  CHECK(picture.pixels() == usual);
  picture.look_at_fronts(true, draw);
  CHECK(picture.share_of_backs() == 0.0);  // one looks into it
  CHECK(picture.pixels() != usual);
}

TEST_CASE("ThePictureDoesNotDependOnTheOrderNorOnTheThreadsThatDraw") {
  // Two surfaces at the same depth, one of a filled hole: ties everywhere.
  std::vector<Corners> triangles = sphere(24);
  const std::size_t one = triangles.size();
  triangles.insert(triangles.end(), triangles.begin(), triangles.begin() + one);
  std::vector<std::int32_t> hole(2 * one, 0);
  std::fill(hole.begin() + one, hole.end(), 1);
  const auto drawn = [&](const std::vector<std::size_t>& order) {
    MeshPicture picture(bounds_of(triangles), kSmall);
    for (const std::size_t i : order) picture.draw({&triangles[i], 1}, {&hole[i], 1});
    return picture.pixels();
  };
  std::vector<std::size_t> order(2 * one);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto forwards = drawn(order);
  CHECK(drawn({order.rbegin(), order.rend()}) == forwards);
  std::mt19937_64 random(5);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  CHECK(drawn(order) == forwards);

  MeshPicture shared(bounds_of(triangles), kSmall);
  const std::span<const Corners> all(triangles);
  const std::span<const std::int32_t> holes(hole);
  std::thread other([&] { shared.draw(all.first(one), holes.first(one)); });
  shared.draw(all.last(one), holes.last(one));
  other.join();
  CHECK(shared.pixels() == forwards);
}

TEST_CASE("ThePictureFollowsTheShapeWhereverItIs") {
  const std::vector<Corners> near = sphere(24);
  const Vec3 utm{448'262.0, 5'411'932.0, 512.0};
  const auto far = sphere(utm, 1.0, 24, [](Vec3) { return true; });
  MeshPicture a(bounds_of(near), kSmall), b(bounds_of(far), kSmall);
  a.draw(near);
  b.draw(far);
  const auto pixels_a = a.pixels(), pixels_b = b.pixels();
  int different = 0;
  for (std::size_t i = 0; i < pixels_a.size(); ++i)
    different += std::abs(pixels_a[i] - pixels_b[i]) > 8;
  CHECK(different < 60);
}

/// A square of side 2 in the plane z = 0, seen from +z counter-clockwise.
std::vector<Corners> square(int cells) {
  std::vector<Corners> triangles;
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto corner = [&](int x, int y) {
        return Vec3{2.0 * x / cells - 1.0, 2.0 * y / cells - 1.0, 0.0};
      };
      triangles.push_back({corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
      triangles.push_back({corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
    }
  return triangles;
}

TEST_CASE("TrianglesSmallerThanASampleLeaveNoGaps") {
  PictureOptions options{.width = 64, .height = 64, .up = UpAxis::kY, .azimuth_deg = 0.0};
  options.elevation_deg = 0.0;
  for (const int cells : {1, 59, 118, 400}) {
    CAPTURE(cells);
    const auto triangles = square(cells);
    MeshPicture picture(bounds_of(triangles), options);
    picture.draw(triangles);
    const Image image{64, 64, picture.pixels()};
    for (int y = 4; y < 60; ++y)
      for (int x = 4; x < 60; ++x) REQUIRE(is_front(image.at(x, y)));
    CHECK(is_background(image.at(1, 32)));
  }
}

TEST_CASE("WhatIsFlatInZIsSeenFromAbove") {
  const auto sheet = square(4);
  MeshPicture picture(bounds_of(sheet), kSmall);
  picture.draw(sheet);
  CHECK(is_front(Image{200, 150, picture.pixels()}.at(100, 75)));
  MeshPicture below(bounds_of(sheet), {.width = 200, .height = 150, .elevation_deg = -40.0});
  below.draw(sheet);
  CHECK(is_back(Image{200, 150, below.pixels()}.at(100, 75)));
}

/// A cone of height 2 about `axis` (0 to 2), its apex at the upper end, outside counter-clockwise.
std::vector<Corners> cone(int axis) {
  constexpr int kSpokes = 48;
  const auto placed = [axis](double height, double a, double b) {
    Vec3 p;
    p[axis] = height;
    p[(axis + 1) % 3] = a;
    p[(axis + 2) % 3] = b;
    return p;
  };
  const auto foot = [&](int spoke) {
    const double around = 2.0 * std::numbers::pi * spoke / kSpokes;
    return placed(-1.0, std::cos(around), std::sin(around));
  };
  std::vector<Corners> triangles;
  for (int spoke = 0; spoke < kSpokes; ++spoke) {
    triangles.push_back({foot(spoke), foot(spoke + 1), placed(1.0, 0.0, 0.0)});
    triangles.push_back({foot(spoke + 1), foot(spoke), placed(-1.0, 0.0, 0.0)});
  }
  return triangles;
}

/// Pixels drawn in the upper half, the lower half, the left and the right half.
struct Halves {
  int upper = 0, lower = 0, left = 0, right = 0;
};

Halves drawn_halves(const Image& image) {
  Halves halves;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (is_background(image.at(x, y))) continue;
      ++(y < image.height / 2 ? halves.upper : halves.lower);
      ++(x < image.width / 2 ? halves.left : halves.right);
    }
  return halves;
}

TEST_CASE("TheUpAxisIsUprightInThePicture") {
  for (const int axis : {0, 1, 2}) {
    CAPTURE(axis);
    const auto triangles = cone(axis);
    PictureOptions options = kSmall;
    options.up = static_cast<UpAxis>(static_cast<int>(UpAxis::kX) + axis);
    MeshPicture picture(bounds_of(triangles), options);
    picture.draw(triangles);
    const Image image{200, 150, picture.pixels()};
    const Halves halves = drawn_halves(image);
    // The foot is wider than the apex, and the two sides of the cone are alike.
    CHECK(halves.lower > 2 * halves.upper);
    CHECK(std::abs(halves.left - halves.right) < halves.upper / 4);
    // Nothing is mirrored: the outside is seen.
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) REQUIRE_FALSE(is_back(image.at(x, y)));
  }
}

TEST_CASE("OfTheShapeAloneZIsUprightWhereItIsLow") {
  const auto upright = [](Vec3 extent) {
    return upright_axis(UpAxis::kAuto, {{1, 1, 1}, Vec3{1, 1, 1} + extent});
  };
  CHECK(upright({134.6, 226.0, 48.2}) == 2);   // a building
  CHECK(upright({5.0, 2.6, 6.0}) == 1);        // a room that stands in y
  CHECK(upright({0.205, 0.145, 0.092}) == 1);  // the Stanford dragon
  CHECK(upright({0.156, 0.154, 0.121}) == 1);  // the Stanford bunny
}

TEST_CASE("TheShapeAloneHasYUprightUnlessItIsFlatInZ") {
  const auto pixels = [](const std::vector<Corners>& triangles, UpAxis up) {
    PictureOptions options = kSmall;
    options.up = up;
    MeshPicture picture(bounds_of(triangles), options);
    picture.draw(triangles);
    return picture.pixels();
  };
  CHECK(pixels(cone(1), UpAxis::kAuto) == pixels(cone(1), UpAxis::kY));
  CHECK(pixels(cone(1), UpAxis::kAuto) != pixels(cone(1), UpAxis::kZ));
  CHECK(pixels(square(4), UpAxis::kAuto) == pixels(square(4), UpAxis::kZ));
}

TEST_CASE("TheUpAxisOfAJobIsTheOneAskedForElseWhatTheJobImplies") {
  Job job;
  std::vector<std::string> files = {"scan.ply"};
  const auto up = [&](const std::string& system) { return picture_up(job, files, system); };
  CHECK(up("") == UpAxis::kAuto);
  job.normals.orientation = Orientation::kGround;
  CHECK(up("") == UpAxis::kZ);
  job.normals.orientation = Orientation::kAuto;
  job.input.poses = "scans.conf";
  CHECK(up("") == UpAxis::kY);
  CHECK(up("EPSG:26912") == UpAxis::kZ);
  for (const char* file : {"scans/*.las", "a.LAZ", "site.e57", "site.ptx.gz"}) {
    CAPTURE(file);
    files = {"scan.ply", file};
    CHECK(up("") == UpAxis::kZ);
  }
  job.normals.up = Vec3{0.9, 0.1, -0.2};
  CHECK(up("") == UpAxis::kX);
  job.normals.up = Vec3{0.1, 0.9, -0.2};
  CHECK(up("") == UpAxis::kY);
  job.normals.up = Vec3{0.0, -1.0, 0.5};  // of a ceiling
  CHECK(up("") == UpAxis::kZ);
  job.output.picture_up = UpAxis::kX;
  CHECK(up("EPSG:26912") == UpAxis::kX);
}

TEST_CASE("PointsAreDrawnAsDotsWithTheirOwnShading") {
  MeshPicture picture({{-1, -1, -1}, {1, 1, 1}}, kSmall);
  const std::vector<Vec3> center = {{0, 0, 0}};
  picture.draw_points(center);
  CHECK(is_front(Image{200, 150, picture.pixels()}.at(100, 75)));
  MeshPicture turned_away({{-1, -1, -1}, {1, 1, 1}}, kSmall);
  turned_away.draw_points(center, std::vector<Vec3>{-kEye});
  CHECK(is_back(Image{200, 150, turned_away.pixels()}.at(100, 75)));
}

TEST_CASE("DegenerateInputIsDrawnAsNothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Corners> odd = {{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
                                    {{{nan, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
                                    {{{0, 0, 0}, {inf, 0, 0}, {0, 1, 0}}},
                                    {{{0, 0, 0}, {1e300, 0, 0}, {0, 1e300, 0}}},
                                    {{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}};
  for (const Box& box : {Box{}, Box{{0, 0, 0}, {0, 0, 0}}, Box{{0, 0, 0}, {0, 1, 0}}}) {
    MeshPicture picture(box, {.width = 20, .height = 10});
    picture.draw(odd);
    picture.draw_points(std::vector<Vec3>{{nan, 0, 0}, {inf, inf, 0}, {1e308, 1e308, 1e308}});
    for (const std::uint8_t value : picture.pixels()) CHECK(value >= 250);
  }
  CHECK_THROWS_AS(MeshPicture(Box{}, PictureOptions{.width = 0}), std::invalid_argument);
}

TEST_CASE("APictureThatCannotBeWrittenIsAResourceError") {
  const test::ScratchDirectory scratch;
  const MeshPicture picture(Box{}, {.width = 2, .height = 2});
  try {
    picture.write_png(scratch / "no/such/folder.png");
    FAIL("written");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    CHECK_THAT(error.what(), Catch::Contains("folder.png"));
  }
}

}  // namespace
}  // namespace orbweave
