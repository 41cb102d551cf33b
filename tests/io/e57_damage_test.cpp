// Damaged E57 files: every one is refused, with file, place and defect.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/io/e57_files.h"
#include "tests/io/reading.h"

namespace orbweave::test {
namespace {

/// Kind kNone where reading throws nothing.
Error error_of(const std::string& bytes) {
  try {
    read_e57(bytes);
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorKind::kNone, "");
}

std::string message_of(const std::string& bytes) {
  const Error error = error_of(bytes);
  CHECK(error.kind() == ErrorKind::kBadInput);
  return error.what();
}

E57File3D small_file() {
  E57Scan3D scan;
  scan.columns = cartesian({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}});
  scan.columns.push_back(integers("cartesianInvalidState", 0, 1, {0, 1, 0}));
  scan.columns.push_back(integers("intensity", 0, 4000, {1, 2, 3}));
  scan.packet_bytes = {8, 9, 10, 1, 1};
  scan.xml = "<description type=\"String\">" + std::string(900, 'd') + "</description>";
  return {.scans = {scan}};
}

using Catch::Matchers::Contains;

/// Replaces the first `from` by `to`; the test fails where there is none.
E57Edit replacing(const std::string& from, const std::string& to) {
  return [=](std::string& text) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
  };
}

std::string message_with_xml(const std::string& from, const std::string& to) {
  return message_of(make_e57(small_file(), replacing(from, to)));
}

/// The file whose logical bytes from `at` on are overwritten, with correct checksums.
std::string message_with_bytes(std::size_t at, const std::string& bytes) {
  return message_of(make_e57(small_file(), nullptr, [&](std::string& logical) {
    logical.replace(at, bytes.size(), bytes);
  }));
}

// Where things lie in small_file().
constexpr std::size_t kSection = 48;
constexpr std::size_t kPacket = kSection + 32;

}  // namespace

TEST_CASE("E57SmallFileIsWholeBeforeItIsDamaged") {
  const PointCloud cloud = read_e57(make_e57(small_file()));
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}, {7, 8, 9}});
}

TEST_CASE("E57EveryFlippedByteIsFound") {
  const std::string whole = make_e57(small_file());
  REQUIRE(whole.size() == 2048);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1 << i % 8);
    if (error_of(damaged).kind() != ErrorKind::kBadInput) FAIL("byte " << i);
  }
}

TEST_CASE("E57WrongChecksumNamesPageAndByte") {
  std::string damaged = make_e57(small_file());
  damaged[1030] ^= 0x10;
  const Error error = error_of(damaged);
  CHECK(error.parts().file == "test.e57");
  CHECK(error.parts().place == "byte 1024");
  CHECK_THAT(error.what(), Contains("the checksum of page 1 (bytes 1024 to 2047) is wrong"));
}

TEST_CASE("E57EveryTruncationIsFound") {
  const std::string whole = make_e57(small_file());
  for (std::size_t size = 0; size < whole.size(); ++size)
    if (error_of(whole.substr(0, size)).kind() != ErrorKind::kBadInput) FAIL("size " << size);
  CHECK_THAT(message_of(""), Contains("too short for an E57 header"));
  CHECK_THAT(message_of(whole.substr(0, 1024)), Contains("shorter than its E57 header says"));
}

TEST_CASE("E57HeadersThatAreNoneAreRefused") {
  CHECK_THAT(message_of(std::string(4096, 'x')), Contains("no E57 file"));
  CHECK_THAT(message_with_bytes(8, std::string("\2")), Contains("version 2"));
  CHECK_THAT(message_with_bytes(40, std::string(8, '\0')), Contains("impossible page size"));
  CHECK_THAT(message_with_bytes(40, std::string(8, '\xFF')), Contains("impossible page size"));
  CHECK_THAT(message_with_bytes(16, std::string(8, '\0')), Contains("no whole number of pages"));
  CHECK_THAT(message_with_bytes(24, std::string(8, '\xFF')), Contains("the XML section points"));
  CHECK_THAT(message_with_bytes(32, std::string(8, '\xFF')), Contains("does not fit"));
}

TEST_CASE("E57OffsetsIntoChecksumsAreRefused") {
  CHECK_THAT(message_with_bytes(24, std::string("\xFD\3\0\0\0\0\0\0", 8)),
             Contains("points into a checksum"));
  E57File3D file = small_file();
  for (const char* offset : {"1020", "2047"}) {
    file.scans[0].file_offset = offset;
    CHECK_THAT(message_of(make_e57(file)), Contains("points into a checksum"));
  }
  for (const char* offset : {"0", "47", "2048", "9223372036854775808", "18446744073709551615"}) {
    file.scans[0].file_offset = offset;
    CHECK_THAT(message_of(make_e57(file)), Contains("points outside of the data"));
  }
}

TEST_CASE("E57RecordCountsThatLieAreRefused") {
  E57File3D file = small_file();
  for (const char* count : {"9223372036854775808", "18446744073709551615", "1000"}) {
    file.scans[0].record_count = count;
    CHECK_THAT(message_of(make_e57(file)),
               Contains("claims more points than its section can hold"));
  }
  file.scans[0].record_count = "4";
  CHECK_THAT(message_of(make_e57(file)), Contains("ends too early") && Contains("found 3 points"));
  file.scans[0].record_count = "2";
  CHECK_THAT(message_of(make_e57(file)), Contains("goes on after its last point"));
  file.scans[0].record_count = "-1";
  CHECK_THAT(message_of(make_e57(file)), Contains("recordCount"));
}

TEST_CASE("E57CountsOfPointsWithoutBitsAreBounded") {
  E57Scan3D scan;
  for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
    scan.columns.push_back(integers(name, 3, 3, {3, 3}));
  CHECK(read_e57(make_e57({.scans = {scan}})).positions == std::vector<Vec3>{{3, 3, 3}, {3, 3, 3}});
  scan.record_count = "9223372036854775808";
  CHECK_THAT(message_of(make_e57({.scans = {scan}})), Contains("claims more points"));
}

TEST_CASE("E57PaddingOfPackedIntegersIsNoPoint") {
  E57File3D file = small_file();
  for (E57Column& column : file.scans[0].columns) column.name.insert(0, "x:");
  const std::vector<std::int64_t> values(5, 1);
  for (const char* name : {"cartesianX", "cartesianY", "cartesianZ"})
    file.scans[0].columns.push_back(integers(name, 0, 1, values));
  file.scans[0].columns.erase(file.scans[0].columns.begin(), file.scans[0].columns.end() - 3);
  file.scans[0].packet_bytes.clear();
  file.scans[0].extra_bytes = 7;
  CHECK(read_e57(make_e57(file)).size() == 5);
  file.scans[0].extra_bytes = 8;
  CHECK_THAT(message_of(make_e57(file)), Contains("goes on after its last point"));
}

TEST_CASE("E57SectionsThatAreNoneAreRefused") {
  CHECK_THAT(message_with_bytes(kSection, "\xB6"),
             Contains("byte 48") && Contains("its id is wrong") && Contains("found 182"));
  CHECK_THAT(message_with_bytes(kSection + 8, std::string(8, '\xFF')),
             Contains("impossible length"));
  CHECK_THAT(message_with_bytes(kSection + 8, std::string(8, '\0')), Contains("impossible length"));
  CHECK_THAT(message_with_bytes(kSection + 16, std::string("\x30\0", 2)),
             Contains("begin outside of its section"));
}

TEST_CASE("E57PacketsThatAreNoneAreRefused") {
  CHECK_THAT(message_with_bytes(kPacket, "\3"), Contains("byte 80") && Contains("unknown type"));
  CHECK_THAT(message_with_bytes(kPacket + 2, "\xFF\xFF"), Contains("impossible length"));
  CHECK_THAT(message_with_bytes(kPacket + 2, std::string(2, '\0')), Contains("impossible length"));
  CHECK_THAT(message_with_bytes(kPacket + 4, "\4"), Contains("found 4 streams, expected 5"));
  CHECK_THAT(message_with_bytes(kPacket + 6, "\xFF\xFF"), Contains("longer than the packet"));
}

TEST_CASE("E57ScansThatShareBytesAreRefused") {
  E57File3D file = small_file();
  file.scans.push_back(file.scans.front());
  file.scans.back().file_offset = "48";
  CHECK_THAT(message_of(make_e57(file)), Contains("the sections of scan 1 and scan 2 overlap"));
}

TEST_CASE("E57DamagedXmlIsRefusedWithItsPlace") {
  CHECK_THAT(message_with_xml("</data3D>", "</data>"),
             Contains("XML section") && Contains("byte "));
  CHECK_THAT(message_with_xml("<e57Root", "<e58Root"), Contains("XML section"));
  const auto rename_root = [](std::string& xml) {
    for (std::size_t at; (at = xml.find("e57Root")) != std::string::npos;) xml[at + 1] = '8';
  };
  CHECK_THAT(message_of(make_e57(small_file(), rename_root)), Contains("no element <e57Root>"));
  CHECK_THAT(message_with_xml("fileOffset", "fileoffset"), Contains("lack the attribute"));
  CHECK_THAT(message_with_xml("recordCount=\"3\"", "recordCount=\"3.5\""), Contains("no integer"));
  CHECK_THAT(message_with_xml("\"CompressedVector\"", "\"Vector\""), Contains("impossible type"));
  CHECK_THAT(message_with_xml("maximum=\"4000\"", "maximum=\"-4000\""),
             Contains("above its maximum"));
  CHECK_THAT(message_with_xml("type=\"Float\"", "type=\"Blob\""), Contains("impossible type"));
  CHECK_THAT(message_with_xml("cartesianX", "cartesianQ"), Contains("have no position"));
}

TEST_CASE("E57ImpossibleScalesAreRefused") {
  const auto message = [](double scale, double offset) {
    E57File3D file = small_file();
    file.scans[0].columns[1] = scaled("cartesianY", 0, 9, scale, offset, {1, 2, 3});
    return message_of(make_e57(file));
  };
  CHECK_THAT(message(0, 0), Contains("impossible scale") && Contains("cartesianY"));
  CHECK_THAT(message(NAN, 0), Contains("impossible scale"));
  CHECK_THAT(message(1, INFINITY), Contains("impossible scale"));
}

TEST_CASE("E57UnknownCodecsAreRefused") {
  E57File3D file = small_file();
  file.scans[0].codecs = "<vectorChild><inputs/><bitPackCodec/></vectorChild>";
  CHECK(error_of(make_e57(file)).kind() == ErrorKind::kNone);
  file.scans[0].codecs = "<vectorChild><inputs/><zip:deflate/></vectorChild>";
  CHECK_THAT(message_of(make_e57(file)), Contains("unknown codec") && Contains("zip:deflate"));
}

TEST_CASE("E57PosesWithoutRotationAreRefused") {
  E57File3D file = small_file();
  for (const char* w : {"0", "nan", "inf"}) {
    file.scans[0].xml = "<pose><rotation><w>" + std::string(w) + "</w></rotation></pose>";
    CHECK_THAT(message_of(make_e57(file)), Contains("no rigid motion"));
  }
  file.scans[0].xml = "<pose><translation><x>far</x></translation></pose>";
  CHECK_THAT(message_of(make_e57(file)), Contains("the value of <x> is no number"));
}

TEST_CASE("E57EntitiesAreNotExpanded") {
  E57File3D file = small_file();
  file.xml = "<coordinateMetadata type=\"String\">&secret;</coordinateMetadata>";
  const auto declare = [](std::string& xml) {
    xml.insert(xml.find("<e57Root"),
               "<!DOCTYPE e57Root [<!ENTITY secret SYSTEM \"file:///etc/hostname\">]>");
  };
  CHECK(open_e57(make_e57(file, declare))->coordinate_system() == "&secret;");
}

TEST_CASE("E57DeepPrototypesAreRefused") {
  std::string deep;
  for (int i = 0; i < 10000; ++i) deep += "<a type=\"Structure\">";
  for (int i = 0; i < 10000; ++i) deep += "</a>";
  const auto nest =
      replacing("<prototype type=\"Structure\">", "<prototype type=\"Structure\">" + deep);
  CHECK_THAT(message_of(make_e57(small_file(), nest)), Contains("nested too deep"));
}

TEST_CASE("AnXmlSectionOfTooManyElementsIsRefusedUnparsed") {
  const auto with_elements = [](std::size_t count) {
    E57File3D file = small_file();
    for (std::size_t i = 0; i < count; ++i) file.xml += "<a/>";
    return make_e57(file);
  };
  CHECK_THAT(message_of(with_elements(600'000)),
             Contains("byte 24: the XML section of the E57 file is too large") &&
                 Contains("whose elements take 3") && Contains("at most 32 MiB"));
  CHECK(error_of(with_elements(100'000)).kind() == ErrorKind::kNone);
}

}  // namespace orbweave::test
