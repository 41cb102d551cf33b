#include "tests/io/e57_files.h"

#include <algorithm>
#include <bit>
#include <charconv>

#include "io/clouds/e57/e57_source.h"
#include "io/streams/random_access.h"
#include "tests/io/reading.h"

namespace orbweave::test {
namespace {

constexpr std::size_t kHeaderBytes = 48;

std::string text_of(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}

/// Bit by bit, unlike the reader's.
std::uint32_t slow_crc32c(const std::string& bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0x82F63B78u : 0u);
  }
  return ~crc;
}

/// Values one after the other, each least significant bit first; the last byte filled up by zeros.
std::string packed(const E57Column& column) {
  std::string bytes;
  unsigned used = 0;  // bits of the last byte
  for (const std::uint64_t word : column.words) {
    for (unsigned bit = 0; bit < column.bits; ++bit) {
      if (used % 8 == 0) bytes += '\0';
      if ((word >> bit & 1) != 0) bytes.back() = static_cast<char>(bytes.back() | 1 << used % 8);
      ++used;
    }
  }
  return bytes;
}

std::string padded(std::string packet) {
  packet.resize((packet.size() + 3) / 4 * 4);
  const std::string length = little_endian(packet.size() - 1, 2);
  std::copy(length.begin(), length.end(), packet.begin() + 2);
  return packet;
}

std::string data_packet(const std::vector<std::string>& streams) {
  std::string packet = little_endian(1, 4) + little_endian(streams.size(), 2);
  for (const std::string& stream : streams) packet += little_endian(stream.size(), 2);
  for (const std::string& stream : streams) packet += stream;
  return padded(packet);
}

/// An index of one entry, as a reader that goes front to back never needs, and an empty packet.
std::string other_packets() {
  std::string index =
      little_endian(0, 4) + little_endian(1, 2) + std::string(10, '\0') + std::string(16, '\x7f');
  return padded(index) + padded(little_endian(2, 4) + std::string(8, '\x55'));
}

std::string make_packets(const E57Scan3D& scan) {
  std::vector<std::string> streams;
  for (const E57Column& column : scan.columns)
    streams.push_back(packed(column) + std::string(scan.extra_bytes, '\0'));
  std::string packets;
  const auto is_left = [](const std::string& stream) { return !stream.empty(); };
  while (std::any_of(streams.begin(), streams.end(), is_left)) {
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < streams.size(); ++i) {
      const std::size_t wanted = scan.packet_bytes.empty() ? 4096 : scan.packet_bytes[i];
      parts.push_back(streams[i].substr(0, wanted));
      streams[i].erase(0, wanted);
    }
    if (scan.with_other_packets) packets += other_packets();
    packets += data_packet(parts);
  }
  return packets;
}

std::string points_xml(const E57Scan3D& scan, std::uint64_t offset) {
  const std::size_t records = scan.columns.empty() ? 0 : scan.columns.front().words.size();
  std::string xml = "<points type=\"CompressedVector\" fileOffset=\"" +
                    (scan.file_offset.empty() ? std::to_string(offset) : scan.file_offset) +
                    "\" recordCount=\"" +
                    (scan.record_count.empty() ? std::to_string(records) : scan.record_count) +
                    "\"><prototype type=\"Structure\">\n";
  for (const E57Column& column : scan.columns)
    xml += "<" + column.name + " " + column.declaration + "/>\n";
  return xml + "</prototype><codecs type=\"Vector\">" + scan.codecs + "</codecs></points>\n";
}

std::string with_checksums(const std::string& logical, std::size_t page_bytes) {
  std::string file;
  for (std::size_t at = 0; at < logical.size(); at += page_bytes - 4) {
    std::string page = logical.substr(at, page_bytes - 4);
    page.resize(page_bytes - 4);
    const std::string crc = little_endian(slow_crc32c(page), 4);
    file += page + std::string(crc.rbegin(), crc.rend());
  }
  return file;
}

/// A source that owns its bytes.
class OwnedSource final : public PointSource {
 public:
  explicit OwnedSource(const std::string& bytes)
      : bytes_(std::make_unique<std::string>(bytes)),
        source_(
            open_e57_source(memory_random_access(std::as_bytes(std::span(*bytes_)), "test.e57"))) {}
  const PointSchema& schema() const override { return source_->schema(); }
  std::optional<std::uint64_t> declared_points() const override {
    return source_->declared_points();
  }
  bool read(PointCloud& batch, std::size_t capacity) override {
    return source_->read(batch, capacity);
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return source_->scanner(); }
  DroppedPoints left_out() const override { return source_->left_out(); }
  std::string coordinate_system() const override { return source_->coordinate_system(); }
  FileFacts facts() const override { return source_->facts(); }
  void skip_parts(const std::function<bool(const Box&)>& is_outside) override {
    source_->skip_parts(is_outside);
  }

 private:
  std::unique_ptr<std::string> bytes_;
  std::unique_ptr<PointSource> source_;
};

}  // namespace

E57Column integers(const std::string& name, std::int64_t minimum, std::int64_t maximum,
                   const std::vector<std::int64_t>& values) {
  E57Column column = scaled(name, minimum, maximum, 1.0, 0.0, values);
  column.declaration = "type=\"Integer\" minimum=\"" + std::to_string(minimum) + "\" maximum=\"" +
                       std::to_string(maximum) + "\"";
  return column;
}

E57Column scaled(const std::string& name, std::int64_t minimum, std::int64_t maximum, double scale,
                 double offset, const std::vector<std::int64_t>& values) {
  E57Column column;
  column.name = name;
  column.declaration = "type=\"ScaledInteger\" minimum=\"" + std::to_string(minimum) +
                       "\" maximum=\"" + std::to_string(maximum) + "\" scale=\"" + text_of(scale) +
                       "\" offset=\"" + text_of(offset) + "\"";
  const auto low = static_cast<std::uint64_t>(minimum);
  std::uint64_t states = static_cast<std::uint64_t>(maximum) - low;
  for (; states != 0; states /= 2) ++column.bits;
  for (const std::int64_t value : values)
    column.words.push_back(static_cast<std::uint64_t>(value) - low);
  return column;
}

E57Column floats(const std::string& name, const std::vector<float>& values) {
  E57Column column{name, "type=\"Float\" precision=\"single\"", 32, {}};
  for (const float value : values) column.words.push_back(std::bit_cast<std::uint32_t>(value));
  return column;
}

E57Column doubles(const std::string& name, const std::vector<double>& values) {
  E57Column column{name, "type=\"Float\"", 64, {}};
  for (const double value : values) column.words.push_back(std::bit_cast<std::uint64_t>(value));
  return column;
}

std::vector<E57Column> cartesian(const std::vector<Vec3>& points) {
  std::vector<double> parts[3];
  for (const Vec3 p : points)
    for (int axis = 0; axis < 3; ++axis) parts[axis].push_back(p[axis]);
  return {doubles("cartesianX", parts[0]), doubles("cartesianY", parts[1]),
          doubles("cartesianZ", parts[2])};
}

std::string make_e57(const E57File3D& file, const E57Edit& edit_xml, const E57Edit& edit_logical) {
  const std::size_t payload = file.page_bytes - 4;
  const auto physical = [&](std::size_t logical) {
    return logical / payload * file.page_bytes + logical % payload;
  };
  std::string logical(kHeaderBytes, '\0');
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
      "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\" " +
      file.root_attributes + ">" + file.xml + "<data3D type=\"Vector\">\n";
  for (const E57Scan3D& scan : file.scans) {
    const std::string packets = make_packets(scan);
    const std::size_t begin = logical.size();
    logical += little_endian(1, 8) + little_endian(32 + packets.size(), 8) +
               little_endian(physical(begin + 32), 8) + little_endian(0, 8) + packets;
    xml += "<vectorChild type=\"Structure\">" + scan.xml + points_xml(scan, physical(begin)) +
           "</vectorChild>\n";
  }
  xml += "</data3D></e57Root>\n";
  if (edit_xml != nullptr) edit_xml(xml);
  const std::size_t pages = (logical.size() + xml.size() + payload - 1) / payload;
  const std::string header = "ASTM-E57" + little_endian(1, 4) + little_endian(0, 4) +
                             little_endian(pages * file.page_bytes, 8) +
                             little_endian(physical(logical.size()), 8) +
                             little_endian(xml.size(), 8) + little_endian(file.page_bytes, 8);
  std::copy(header.begin(), header.end(), logical.begin());
  logical += xml;
  if (edit_logical != nullptr) edit_logical(logical);
  return with_checksums(logical, file.page_bytes);
}

std::unique_ptr<PointSource> open_e57(const std::string& bytes) {
  return std::make_unique<OwnedSource>(bytes);
}

PointCloud read_e57(const std::string& bytes) { return read_all(*open_e57(bytes)); }

}  // namespace orbweave::test
