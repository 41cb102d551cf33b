// What a job file and the command line say, as the job they make.
#include "io/job/job_file.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <locale>
#include <set>

#include "io/error.h"
#include "io/job/setting.h"
#include "io/system/glob.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

Job with(const std::string& name, const std::string& text) {
  Job job;
  set_job_key(job, name, text);
  return job;
}

using Catch::Contains;
using test::write_text;
using Strings = std::vector<std::string>;

constexpr const char* kWholeJob = R"(
[input]
files = ["scans/*.ply", "one.xyz"]
columns = ["x", "y", "z"]
separator = "tab"
poses = "scans/scans.conf"
pose = ["a.ply 1 2 3 0 0 0 1", "b.ply 1 0 0 4 0 1 0 5 0 0 1 6 0 0 0 1"]
scanner = [0, 0, 1, 0]
trajectory = "scans/path.txt"
las_classes = [2, 6]
drop_classes = [12]
returns = "last"
crop = [-1, -2, 3, 4.5, 5, 6]
crop_area = "areas/site.geojson"
every = 20
[cleaning]
auto = true
outlier_sigma = 3.5
merge_tolerance = 1e-4
smooth_radius = 0.25
smooth_passes = 3
thin_to_spacing = 0.125
[partition]
memory = "512 MiB"
chunk_points = 20_000
[normals]
source = "estimate"
neighbors = 24
orientation = "viewpoint"
viewpoint = [1, -2.5, 3]
up = [0, 0, 2]
[reconstruct]
method = "ball_pivoting"
ball_radii = [0.0015, 1, +2.5e0]
levels = 3
[fill]
enabled = false
kernel = "triharmonic"
neighborhood = 3
max_diameter = 2.5
max_perimeter = 1e3
max_edges = 400
keep_outer_border = false
allow_intersections = false
graded = false
min_triangles = 20
[output]
mesh = "out mesh.ply"
format = "text"
precision = "float"
attributes = false
report = "r.json"
picture = "/tmp/p.png"
picture_up = "x"
patch_color = "#4477cC"
[run]
threads = 2
work_dir = "w"
keep_work_dir = true
)";

TEST_CASE("EveryKeyOfAJobFileReachesTheJob") {
  const Job job = parse_job(kWholeJob, "job.toml");
  CHECK(job.input.files == Strings{"scans/*.ply", "one.xyz"});
  CHECK(job.input.text.columns == Strings{"x", "y", "z"});
  CHECK(job.input.text.separator == '\t');
  CHECK(job.input.poses == "scans/scans.conf");
  REQUIRE(job.input.pose.size() == 2);
  CHECK(job.input.pose[0].file == "a.ply");
  CHECK(job.input.pose[0].motion.point({}) == Vec3{1, 2, 3});
  CHECK(job.input.pose[1].motion.point({1, 1, 1}) == Vec3{5, 6, 7});
  CHECK(job.input.scanner == ScannerPlace{{0, 0, 1}, true});
  CHECK(job.input.trajectory == "scans/path.txt");
  CHECK(job.input.las_classes == std::vector<int>{2, 6});
  CHECK(job.input.drop_classes == std::vector<int>{12});
  CHECK(job.input.returns == ReturnFilter::kLast);
  CHECK(job.input.crop == Box{{-1, -2, 3}, {4.5, 5, 6}});
  CHECK(job.input.crop_area == "areas/site.geojson");
  CHECK(job.input.every == 20);
  CHECK(job.cleaning.automatic);
  CHECK(job.cleaning.outlier_sigma == 3.5);
  CHECK(job.cleaning.merge_tolerance == 1e-4);
  CHECK(job.cleaning.smooth_radius == 0.25);
  CHECK(job.cleaning.smooth_passes == 3);
  CHECK(job.cleaning.thin_to_spacing == 0.125);
  CHECK(job.normals.source == NormalSource::kEstimate);
  CHECK(job.normals.neighbors == 24);
  CHECK(job.normals.orientation == Orientation::kViewpoint);
  CHECK(job.normals.viewpoint == Vec3{1, -2.5, 3});
  CHECK(job.normals.up == Vec3{0, 0, 2});
  CHECK(job.partition.memory_bytes == std::uint64_t{512} << 20);
  CHECK(job.partition.chunk_points == 20000);
  CHECK(job.reconstruct.ball_radii == std::vector<double>{0.0015, 1.0, 2.5});
  CHECK(job.reconstruct.levels == 3);
  CHECK_FALSE(job.fill.enabled);
  CHECK(job.fill.kernel == FillKernel::kTriharmonic);
  CHECK(job.fill.neighborhood == 3.0);
  CHECK(job.fill.max_diameter == 2.5);
  CHECK(job.fill.max_perimeter == 1000.0);
  CHECK(job.fill.max_edges == 400);
  CHECK_FALSE(job.fill.keep_outer_border);
  CHECK_FALSE(job.fill.allow_intersections);
  CHECK_FALSE(job.fill.graded);
  CHECK(job.fill.min_triangles == 20);
  CHECK(job.output.mesh == "out mesh.ply");
  CHECK_FALSE(job.output.binary);
  CHECK(job.output.float_positions);
  CHECK_FALSE(job.output.attributes);
  CHECK(job.output.report == "r.json");
  CHECK(job.output.picture == "/tmp/p.png");
  CHECK(job.output.picture_up == UpAxis::kX);
  CHECK(job.output.patch_color == std::array<std::uint8_t, 3>{0x44, 0x77, 0xcc});
  CHECK(job.run.threads == 2);
  CHECK(job.run.work_dir == "w");
  CHECK(job.run.keep_work_dir);
}

TEST_CASE("KeysLeftOutKeepTheirDefaults") {
  const Job job = parse_job("# nothing\n[reconstruct]\nball_radii = \"auto\"\n", "job.toml");
  CHECK(job_toml(job) == job_toml(Job{}));
  CHECK(job_toml(parse_job("", "job.toml")) == job_toml(Job{}));
}

TEST_CASE("HowWideAHoleMayBeFollowsFromTheScanUnlessSaidOtherwise") {
  const FillOptions fill = parse_job("[fill]\n", "job.toml").fill;
  CHECK(fill.enabled);
  CHECK(fill.keep_outer_border);
  CHECK_FALSE(fill.max_diameter);
  CHECK_FALSE(parse_job("[fill]\nmax_diameter = \"auto\"\n", "job.toml").fill.max_diameter);
  CHECK(std::isinf(fill.max_perimeter));
  CHECK(fill.max_edges == 0);
  CHECK_FALSE(fill.allow_intersections);
  CHECK_FALSE(fill.min_triangles);
  CHECK(parse_job("[fill]\nmin_triangles = \"auto\"\n", "job.toml").fill.min_triangles ==
        fill.min_triangles);
  CHECK(parse_job("[fill]\nmin_triangles = 0\n", "job.toml").fill.min_triangles == 0u);
}

TEST_CASE("ALimitOnHolesMayBeInfinite") {
  for (const char* limit : {"inf", "+inf"}) {
    Job job;
    job.fill.max_diameter = job.fill.max_perimeter = 1.0;
    set_job_key(job, "fill.max_diameter", limit);
    set_job_key(job, std::string("fill.max_perimeter=") + limit);
    CHECK(job.fill.max_diameter == std::numeric_limits<double>::infinity());
    CHECK(std::isinf(job.fill.max_perimeter));
  }
  const Job job = parse_job("[fill]\nmax_diameter = inf\n", "job.toml");
  CHECK(job.fill.max_diameter == std::numeric_limits<double>::infinity());
  CHECK_THAT(job_toml(job), Contains("\nmax_diameter = inf\n"));
  CHECK_THAT(job_toml(Job{}), Contains("\nmax_diameter = \"auto\"\n"));
}

TEST_CASE("NumbersOfACommandLineNeedNoZeroBesideTheirPoint") {
  CHECK(with("fill.max_diameter", ".5").fill.max_diameter == 0.5);
  CHECK(with("fill.max_diameter", "5.").fill.max_diameter == 5.0);
  CHECK(with("fill.max_diameter", "5.e-1").fill.max_diameter == 0.5);
  CHECK(with("reconstruct.ball_radii", ".5,1.,2").reconstruct.ball_radii ==
        std::vector<double>{0.5, 1.0, 2.0});
  CHECK(with("normals.up", "0,-.5,1.").normals.up == Vec3{0.0, -0.5, 1.0});
  for (const char* wrong : {".", "-.", "1.2.3", "..5", "5.."})
    CHECK_THROWS_AS(with("fill.max_diameter", wrong), Error);
  CHECK_THROWS_AS(parse_job("[fill]\nmax_diameter = .5\n", "job.toml"), Error);  // no TOML
}

TEST_CASE("AJobWrittenAsTomlReadsBackAsTheSameJob") {
  Job job = parse_job(kWholeJob, "job.toml");
  job.output.mesh = "odd \"name\"\t\\ \x01 ü.ply";
  job.reconstruct.ball_radii = {0.1, 1.0 / 3.0, 4e3};
  job.partition.memory_bytes = 1000000001;
  const Job back = parse_job(job_toml(job), "job.toml");
  CHECK(job_toml(back) == job_toml(job));
  CHECK(back.output.mesh == job.output.mesh);
  CHECK(back.reconstruct.ball_radii == job.reconstruct.ball_radii);
  CHECK(back.partition.memory_bytes == 1000000001);
}

TEST_CASE("RelativePathsOfAJobFileAreRelativeToItsFolder") {
  const Job job = parse_job(
      "[input]\nfiles = [\"a/*.ply\", \"b.ply\", \"/c.ply\"]\n[output]\nmesh = \"m.ply\"\n"
      "report = \"\"\npicture = \"-\"\n[run]\nwork_dir = \"../w\"\n",
      "job.toml", "jobs/deep[1]");
  CHECK(job.input.files == Strings{"jobs/deep\\[1]/a/*.ply", "jobs/deep[1]/b.ply", "/c.ply"});
  CHECK(job.output.mesh == "jobs/deep[1]/m.ply");
  CHECK(job.output.report.empty());
  CHECK(job.output.picture == "-");
  CHECK(job.run.work_dir == "jobs/deep[1]/../w");
}

TEST_CASE("AJobFileInAnotherFolderFindsItsScansByPattern") {
  const test::ScratchDirectory scratch;
  const auto folder = scratch / "odd [1] *";
  std::filesystem::create_directories(folder / "scans.ply");
  for (const char* name : {"b.ply", "a.ply", "C.ply", "other.xyz"}) write_text(folder / name, "x");
  write_text(folder / "job.toml", "[input]\nfiles = [\"*.ply\", \"a.ply\"]\n");
  const Job job = read_job_file(folder / "job.toml");
  CHECK(expand_globs(job.input.files) == Strings{(folder / "C.ply").string(),
                                                 (folder / "a.ply").string(),
                                                 (folder / "b.ply").string()});
}

TEST_CASE("SettingAKeyTakesTomlValuesAndBareWords") {
  CHECK(with("partition.memory", "2GiB").partition.memory_bytes == std::uint64_t{2} << 30);
  CHECK(with("partition.memory", "512 MiB").partition.memory_bytes == std::uint64_t{512} << 20);
  CHECK(with("partition.memory", "\"1GB\"").partition.memory_bytes == 1000000000);
  CHECK(with("partition.memory", "100000000").partition.memory_bytes == 100000000);
  CHECK(with("partition.chunk_points", "1_000").partition.chunk_points == 1000);
  CHECK(with("partition.chunk_points", "auto").partition.chunk_points == 0);
  CHECK(with("reconstruct.ball_radii", "0.0015").reconstruct.ball_radii ==
        std::vector<double>{0.0015});
  CHECK(with("reconstruct.ball_radii", "0.5,1, 2").reconstruct.ball_radii ==
        std::vector<double>{0.5, 1.0, 2.0});
  CHECK(with("reconstruct.ball_radii", "[0.5, 1]").reconstruct.ball_radii ==
        std::vector<double>{0.5, 1.0});
  CHECK(with("output.mesh", "out/mesh.ply").output.mesh == "out/mesh.ply");
  CHECK(with("output.mesh", "12").output.mesh == "12");
  CHECK(with("output.mesh", "'my mesh.ply'").output.mesh == "my mesh.ply");
  CHECK(with("output.mesh", "it's.ply").output.mesh == "it's.ply");
  CHECK(with("output.attributes", "false").output.attributes == false);
  CHECK(with("output.format", "text").output.binary == false);
  CHECK(with("output.format", "auto").output.binary);
  CHECK_FALSE(with("output.format", "auto").output.requires_binary);
  CHECK(with("output.format", "binary").output.requires_binary);
  CHECK(with("input.columns", "x,y,z").input.text.columns == Strings{"x", "y", "z"});
  CHECK(with("input.files", "[\"a.ply\", \"b.ply\"]").input.files == Strings{"a.ply", "b.ply"});
  CHECK(with("input.separator", ",").input.text.separator == ',');
  CHECK(with("fill.kernel", "triharmonic").fill.kernel == FillKernel::kTriharmonic);
  CHECK(with("fill.max_diameter", "0.25").fill.max_diameter == 0.25);
  CHECK(with("fill.max_edges", "60").fill.max_edges == 60);
  CHECK(with("output.patch_color", "#ff8000").output.patch_color ==
        std::array<std::uint8_t, 3>{255, 128, 0});
}

TEST_CASE("TheFormerNameOfTheCleaningSectionIsTheSameSection") {
  const std::string keys =
      "auto = true\noutlier_sigma = 3.5\nmerge_tolerance = 1e-4\nsmooth_radius = 0.25\n"
      "smooth_passes = 3\nthin_to_spacing = 0.125\n";
  const std::string now = job_toml(parse_job("[cleaning]\n" + keys, "job.toml"));
  CHECK(job_toml(parse_job("[prepare]\n" + keys, "job.toml")) == now);
  CHECK(job_toml(parse_job("prepare.auto = true\n", "job.toml")) ==
        job_toml(parse_job("cleaning.auto = true\n", "job.toml")));
  CHECK(job_toml(with("prepare.smooth_radius", "0.25")) ==
        job_toml(with("cleaning.smooth_radius", "0.25")));
  CHECK_THAT(now, Contains("\n[cleaning]\nauto = true\n") && !Contains("prepare"));
}

TEST_CASE("ASettingIsNamedAsTheUserOfTheJobGivesIt") {
  Job job;
  CHECK(setting_name(job, "cleaning.smooth_radius") == "cleaning.smooth_radius");
  CHECK(setting(job, "cleaning.auto", "true") == "cleaning.auto = true");
  CHECK(setting(job, "normals.source", "estimate") == "normals.source = \"estimate\"");
  CHECK(setting(job, "reconstruct.ball_radii", "auto") == "reconstruct.ball_radii = \"auto\"");
  job.run.is_from_command_line = true;
  CHECK(setting_name(job, "cleaning.smooth_radius") == "--smooth-radius");
  CHECK(setting(job, "cleaning.auto", "true") == "--cleaning");
  CHECK(setting(job, "fill.enabled", "false") == "--no-fill");
  CHECK(setting(job, "fill.enabled", "true") == "no --no-fill");
  CHECK(setting(job, "normals.source", "estimate") == "--normals estimate");
  CHECK(setting(job, "reconstruct.ball_radii", "auto") == "--ball-radii auto");
  CHECK(setting_name(job, "input.pose") == "input.pose");  // has no option
}

TEST_CASE("ACropOfXAndYAloneHasNoLimitsInZ") {
  const Job job = with("input.crop", "[1, 2, 3, 4]");
  CHECK(job.input.crop->contains({1, 4, 1e300}));
  CHECK_FALSE(job.input.crop->contains({1, 4.5, 0}));
  CHECK(parse_job(job_toml(job), "job.toml").input.crop == job.input.crop);
  CHECK_FALSE(with("input.crop", "none").input.crop);
  CHECK(with("input.drop_classes", "none").input.drop_classes.empty());
}

TEST_CASE("AnAreaIsAPathBesideTheJobFileOrTextAsItIs") {
  const auto area_of_key = [](const std::string& value) {
    return parse_job("[input]\ncrop_area = \"" + value + "\"\n", "job.toml", "jobs")
        .input.crop_area;
  };
  CHECK(area_of_key("site.wkt") == "jobs/site.wkt");
  CHECK(area_of_key("POLYGON ((0 0, 1 0, 1 1))") == "POLYGON ((0 0, 1 0, 1 1))");
  CHECK(area_of_key("") == "");
}

TEST_CASE("TheKeyTableIsCompleteAndItsDefaultsAreAccepted") {
  std::set<std::string> names;
  std::set<std::string> options;
  for (const JobKey& key : job_keys()) {
    CAPTURE(key.name());
    CHECK(names.insert(key.name()).second);
    if (*key.option != '\0') CHECK(options.insert(key.option).second);
    CHECK_FALSE(key.expected().empty());
    CHECK_FALSE(std::string(key.help).empty());
    CHECK_FALSE(std::string(type_name(key.type)).empty());
    Job job;
    CHECK_NOTHROW(set_job_key(job, key.name(), key.default_text()));
    if (*key.option_value != '\0') CHECK_NOTHROW(set_job_key(job, key.name(), key.option_value));
  }
  CHECK(names.size() == 72);
  CHECK(options.count("ball-radii") == 1);
}

TEST_CASE("TheJobFilesThatUsersCopyAreRead") {
  const Job object = read_job_file(test::source_path("configs/object.toml"));
  CHECK(object.reconstruct.ball_radii.empty());
  CHECK(object.reconstruct.levels == 3);
  CHECK(object.fill.enabled);
  const Job terrain = read_job_file(test::source_path("configs/terrain.toml"));
  CHECK(terrain.fill.enabled);
  CHECK(terrain.fill.keep_outer_border);
  CHECK_FALSE(terrain.output.float_positions);
  const Job large = read_job_file(test::source_path("configs/large-scan.toml"));
  CHECK(large.reconstruct.ball_radii.size() == 1);
  CHECK(large.partition.chunk_points > 0);
  CHECK(large.partition.memory_bytes == std::uint64_t{8} << 30);
}

TEST_CASE("PatternsExpandToSortedFilesOncePerFile") {
  const test::ScratchDirectory scratch;
  for (const char* name : {"s2.ply", "s10.ply", "s1.ply", "odd[1].ply"})
    write_text(scratch / name, "x");
  const auto path = [&](const char* name) { return (scratch / name).string(); };
  CHECK(expand_globs({path("s?.ply"), path("s*.ply")}) ==
        Strings{path("s1.ply"), path("s2.ply"), path("s10.ply")});
  // The name of a file that looks like a pattern, and a name without a file, pass through.
  CHECK(expand_globs({path("odd[1].ply"), path("none.ply")}) ==
        Strings{path("odd[1].ply"), path("none.ply")});
  for (const char* beside : {"s1.prj", "s1.ply.shift.txt", "s.conf", "s.aln"})
    write_text(scratch / beside, "x");
  CHECK(expand_globs({path("s*")}) == expand_globs({path("s*.ply")}));
  CHECK(expand_globs({path("s1.prj")}) == Strings{path("s1.prj")});
  CHECK_THROWS_WITH(expand_globs({path("*.prj")}), Contains("no file matches this pattern"));
  CHECK_THROWS_WITH(expand_globs({path("*.las")}),
                    Contains(path("*.las") + ": no file matches this pattern"));
}

TEST_CASE("APatternForFoldersAtAnyDepthIsRefused") {
  const test::ScratchDirectory scratch;
  std::filesystem::create_directories(scratch / "a" / "b");
  for (const char* name : {"1.ply", "a/2.ply", "a/b/3.ply"}) write_text(scratch / name, "x");
  const auto path = [&](const char* name) { return (scratch / name).string(); };
  for (const std::string& pattern : {path("**/*.ply"), std::string("**/*.ply")})
    CHECK_THROWS_WITH(expand_globs({pattern}), Contains("does not search folders within folders") &&
                                                   Contains("scans/*/*.las"));
  CHECK(expand_globs({path("*.ply"), path("*/*.ply"), path("*/b/**.ply")}) ==
        Strings{path("1.ply"), path("a/2.ply"), path("a/b/3.ply")});
}

TEST_CASE("FilesThatAPatternMissesForACapitalLetterAreKnown") {
  const test::ScratchDirectory scratch;
  for (const char* name : {"a.laz", "B.LAZ", "C.Las", "d.ply"}) write_text(scratch / name, "x");
  const auto path = [&](const char* name) { return (scratch / name).string(); };
  CHECK(files_in_other_case({path("*.la[sz]")}) == Strings{path("B.LAZ"), path("C.Las")});
  CHECK(files_in_other_case({path("*.la[!s]")}) == Strings{path("B.LAZ")});
  CHECK(files_in_other_case({path("*.laz"), path("B.*")}).empty());
  CHECK(files_in_other_case({path("*.ply"), path("d.ply"), path("*")}).empty());
  CHECK_THROWS_WITH(expand_globs({path("[B].l?z")}),
                    Contains("Capital and small letters differ: " + path("B.LAZ") + " is there"));
  CHECK_THROWS_WITH(expand_globs({path("*.pcd")}), Contains("Check the folder"));
}

TEST_CASE("ANumberIsTheSameInEveryLocale") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
  const Job job = parse_job("[reconstruct]\nball_radii = [1.25]\n[run]\nthreads = 1234\n", "");
  const std::string text = job_toml(job);
  std::locale::global(before);
  CHECK(job.reconstruct.ball_radii == std::vector<double>{1.25});
  CHECK(job.run.threads == 1234);
  CHECK(text == job_toml(job));
}

}  // namespace
}  // namespace orbweave
