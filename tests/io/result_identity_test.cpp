// What is stored belongs to one work directory, stage and place, and is taken nowhere else.
#include "io/store/result_identity.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>
#include <string>

#include "io/store/chunk_store.h"
#include "io/store/chunk_store_file.h"
#include "tests/io/stored_arrays.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::Arrays;
using test::file_text;
using test::make_arrays;
using test::same;
using test::status_of;
using test::write_text;

constexpr std::size_t kRows = 2500;

/// Two stages of four results and a document each.
void fill(const fs::path& directory, const std::string& key = "key") {
  ChunkStore store(directory);
  for (const char* stage : {"raw_normals", "mesh"}) {
    store.begin_stage(stage, key);
    for (ChunkId chunk = 0; chunk < 4; ++chunk)
      store.commit(stage, chunk, make_arrays(kRows, chunk).views(), true);
    store.commit_document(stage, "facts", "{\"of\": 1}");
    store.commit_document(stage, "others", "{\"of\": 2}");
  }
}

/// Why the store refuses a result; empty: it takes it.
std::string refusal(const fs::path& directory, const std::string& stage, ChunkId chunk) {
  const ChunkStore store(directory);
  try {
    store.open(stage, chunk);
    return {};
  } catch (const CorruptResult& damage) {
    CHECK(damage.kind() == ErrorKind::kResource);
    CHECK(damage.path() == directory / stage / ("00000" + std::to_string(chunk) + ".h5"));
    return damage.parts().found;
  }
}

void copy_over(const fs::path& from, const fs::path& to) {
  fs::copy_file(from, to, fs::copy_options::overwrite_existing);
}

}  // namespace

TEST_CASE("TwoExchangedResultsAreBothRefusedAndNamed") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fs::rename(work / "raw_normals/000001.h5", work / "kept");
  fs::rename(work / "raw_normals/000003.h5", work / "raw_normals/000001.h5");
  fs::rename(work / "kept", work / "raw_normals/000003.h5");
  CHECK(refusal(work, "raw_normals", 1) == "the result of chunk 3 of stage raw_normals");
  CHECK(refusal(work, "raw_normals", 3) == "the result of chunk 1 of stage raw_normals");
  CHECK(refusal(work, "raw_normals", 2).empty());
}

TEST_CASE("AResultOfAnotherStageOrDirectoryIsRefusedAndNamed") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fill(scratch / "other");
  copy_over(work / "mesh/000002.h5", work / "raw_normals/000002.h5");
  CHECK(refusal(work, "raw_normals", 2) == "the result of chunk 2 of stage mesh");
  copy_over(scratch / "other/mesh/000001.h5", work / "mesh/000001.h5");
  CHECK(refusal(work, "mesh", 1) ==
        "the result of chunk 1 of stage mesh of another work directory");
}

TEST_CASE("AResultFromBeforeTheKeyChangedIsRefusedThoughItLiesInItsPlace") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  const std::string key = GENERATE("another key", "key");  // the same one begun anew, too
  fill(work);
  fs::copy(work, scratch / "before", fs::copy_options::recursive);
  {
    ChunkStore store(work);
    store.begin_stage_anew("mesh", key);
    CHECK_FALSE(store.has("mesh", 0));
    store.commit("mesh", 0, make_arrays(kRows, 9).views(), true);
  }
  copy_over(scratch / "before/mesh/000001.h5", work / "mesh/000001.h5");
  copy_over(scratch / "before/mesh/facts.json", work / "mesh/facts.json");
  copy_over(scratch / "before/mesh/facts.json.xxh3", work / "mesh/facts.json.xxh3");
  CHECK(refusal(work, "mesh", 0).empty());
  CHECK(refusal(work, "mesh", 1) ==
        "the result of chunk 1 of stage mesh from before the stage was begun anew");
  CHECK_FALSE(ChunkStore(work).document("mesh", "facts"));
}

TEST_CASE("BlocksOfEqualShapeHaveOtherChecksumsInOtherResults") {
  const ResultIdentity one = {"a", "mesh", "c", "chunk 1"};
  std::set<std::uint64_t> seeds;
  for (const ResultIdentity& identity :
       {one, ResultIdentity{"b", "mesh", "c", "chunk 1"},
        ResultIdentity{"a", "raw", "c", "chunk 1"}, ResultIdentity{"a", "mesh", "d", "chunk 1"},
        ResultIdentity{"a", "mesh", "c", "chunk 2"}})
    for (const char* array : {"triangles", "fans"})
      seeds.insert(seed_of_checksums(identity, array));
  CHECK(seeds.size() == 10);
}

TEST_CASE("ADocumentCountsInItsPlaceOnly") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fill(scratch / "other");
  const auto put = [&](const fs::path& from, const std::string& stage, const std::string& name) {
    for (const char* ending : {".json", ".json.xxh3"})
      copy_over(from.string() + ending, (work / stage / (name + ending)).string());
  };
  REQUIRE(ChunkStore(work).document("mesh", "facts"));
  const std::string from =
      GENERATE("work/mesh/others", "work/raw_normals/facts", "other/mesh/facts");
  put(scratch / from, "mesh", "facts");
  CHECK_FALSE(ChunkStore(work).document("mesh", "facts"));
  CHECK(ChunkStore(work).document("raw_normals", "facts"));
}

TEST_CASE("AKeyCountsInItsPlaceOnly") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fill(scratch / "other");
  REQUIRE(ChunkStore(work).has_key("mesh", "key"));
  const std::string from = GENERATE("work/raw_normals/key.json", "other/mesh/key.json");
  copy_over(scratch / from, work / "mesh/key.json");
  const ChunkStore store(work);
  CHECK_FALSE(store.has_key("mesh", "key"));
  CHECK_FALSE(store.key("mesh"));
  CHECK(store.has_key("raw_normals", "key"));
}

TEST_CASE("AKeyKeepsBytesThatAreNoText") {
  const test::ScratchDirectory scratch;
  const std::string key = "sc\xe4n\\x41.ply\x1b = 12 \xff\n";
  { ChunkStore(scratch / "work").begin_stage("mesh", key); }
  const ChunkStore store(scratch / "work");
  CHECK(store.key("mesh") == key);
  CHECK(store.has_key("mesh", key));
  CHECK_FALSE(store.has_key("mesh", "sc\xe4n\\x41.ply\x1b = 12 \\xff\n"));
}

TEST_CASE("AStageThatIsBegunAnewTakesNewResultsOnly") {
  const test::ScratchDirectory scratch;
  const Arrays arrays = make_arrays(kRows, 1);
  ChunkStore store(scratch / "work");
  store.begin_stage("mesh", "key");
  store.commit("mesh", 0, arrays.views(), true);
  CHECK(same(*store.open("mesh", 0), arrays));
  store.begin_stage_anew("mesh", "key");
  CHECK_FALSE(store.has("mesh", 0));
  store.commit("mesh", 0, arrays.views(), true);
  CHECK(same(*store.open("mesh", 0), arrays));
}

TEST_CASE("DamagedResultsOfAStageAreDiscardedAndTheSoundOnesStay") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fs::resize_file(work / "mesh/000000.h5", 100);
  copy_over(work / "mesh/000003.h5", work / "mesh/000001.h5");
  write_text(work / "mesh/mine.h5", "of the user");
  ChunkStore store(work);
  store.discard_damaged("mesh");
  CHECK_FALSE(store.has("mesh", 0));
  CHECK_FALSE(store.has("mesh", 1));
  CHECK(store.has("mesh", 2));
  CHECK(store.has("mesh", 3));
  CHECK(file_text(work / "mesh/mine.h5") == "of the user");
}

TEST_CASE("ADirectoryInPlaceOfAResultIsNamedAndStays") {
  const test::ScratchDirectory scratch;
  const fs::path work = scratch / "work";
  fill(work);
  fs::remove(work / "mesh/000001.h5");
  fs::create_directory(work / "mesh/000001.h5");
  write_text(work / "mesh/000001.h5/mine", "of the user");
  const ChunkStore store(work);
  std::string message;
  CHECK(status_of([&] { store.open("mesh", 1); }, &message) == ErrorKind::kUsage);
  CHECK(message == (work / "mesh/000001.h5").string() +
                       ": this program did not write what is there; found a directory that is "
                       "not on its record, expected a file of the job's work, or nothing. Move it "
                       "away and repeat the command, which resumes; or name another directory "
                       "with run.work_dir or --work-dir");
  CHECK(file_text(work / "mesh/000001.h5/mine") == "of the user");
}

TEST_CASE("AnIdentityReadsBackFromItsText") {
  const ResultIdentity identity = {new_id(), "raw_normals", new_id(), "chunk 37"};
  CHECK(identity_from(identity.text()) == identity);
  CHECK_FALSE(identity_from(""));
  CHECK_FALSE(identity_from(identity.text() + "\n"));
  CHECK_FALSE(identity_from(identity.text().substr(1)));
  CHECK(is_new_id(identity.store));
  CHECK(new_id() != new_id());
  CHECK_FALSE(is_new_id("0123456789abcdeF0123456789abcdef"));
}

}  // namespace orbweave
