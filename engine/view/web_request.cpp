#include "engine/view/web_request.h"

#include <algorithm>
#include <charconv>
#include <utility>

namespace orbweave {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_word(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// The value of a field; empty: there is none, or an empty one.
std::string_view field(std::string_view head, std::string_view name) {
  for (std::size_t at = head.find("\r\n"); at != std::string_view::npos;) {
    const std::size_t begin = at + 2, end = head.find("\r\n", begin);
    const std::string_view line = head.substr(begin, end - begin);
    const std::size_t colon = line.find(':');
    if (colon != std::string_view::npos && same_word(line.substr(0, colon), name))
      return trimmed(line.substr(colon + 1));
    at = end;
  }
  return {};
}

/// The port does not matter: it may be forwarded.
bool is_loopback(std::string_view host) {
  if (host.starts_with("[::1]")) return host.size() == 5 || host[5] == ':';
  const std::string_view name = host.substr(0, host.find(':'));
  return name == "127.0.0.1" || same_word(name, "localhost");
}

/// No folders, no hidden files.
bool is_plain_name(std::string_view name) {
  return !name.empty() && name[0] != '.' && std::ranges::all_of(name, [](char c) {
    return (c >= '0' && c <= '9') || (lower(c) >= 'a' && lower(c) <= 'z') || c == '.' || c == '-' ||
           c == '_';
  });
}

std::string_view media_type(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".json", "application/json"},
      {".glb", "model/gltf-binary"}};
  for (const auto& [extension, type] : kTypes)
    if (name.ends_with(extension)) return type;
  return "application/octet-stream";
}

WebAnswer answer_of(std::string_view status, std::string_view fields, bool closes) {
  WebAnswer answer;
  answer.closes = closes;
  answer.head = "HTTP/1.1 " + std::string(status) + "\r\n" + std::string(fields) +
                "Cache-Control: no-cache\r\nX-Content-Type-Options: nosniff\r\n" +
                (closes ? "Connection: close\r\n" : "") + "\r\n";
  return answer;
}

WebAnswer refusal(std::string_view status, bool is_head, bool closes, std::string_view more = {}) {
  const std::string text = std::string(status) + "\n";
  WebAnswer answer = answer_of(status,
                               std::string(more) + "Content-Type: text/plain\r\nContent-Length: " +
                                   std::to_string(text.size()) + "\r\n",
                               closes);
  if (!is_head) answer.text = text;
  return answer;
}

struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t bytes = 0;  ///< 0: of the range, the file has none
};

std::optional<std::uint64_t> number(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Empty: no range, several, or none that can be read; then all of the file is sent.
std::optional<ByteRange> range_of(std::string_view text, std::uint64_t size) {
  constexpr std::string_view kUnit = "bytes=";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  const std::size_t dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view from = text.substr(0, dash), to = text.substr(dash + 1);
  const auto first = number(from), last = number(to);
  if (from.empty() && last) {
    const std::uint64_t bytes = std::min(*last, size);
    return ByteRange{size - bytes, bytes};
  }
  if (!first || (!to.empty() && (!last || *last < *first))) return std::nullopt;
  if (*first >= size) return ByteRange{};
  return ByteRange{*first, last ? std::min(*last - *first, size - *first - 1) + 1 : size - *first};
}

WebAnswer file_answer(std::string_view head, const std::string& name, std::uint64_t size,
                      bool is_head, bool closes) {
  // If-Range asks for the range of a version of the file; this server gives no versions out.
  const bool takes_range = !is_head && field(head, "If-Range").empty();
  const auto range = takes_range ? range_of(field(head, "Range"), size) : std::nullopt;
  const std::string total = "/" + std::to_string(size) + "\r\n";
  if (range && range->bytes == 0)
    return refusal("416 Range Not Satisfiable", is_head, closes, "Content-Range: bytes *" + total);
  const ByteRange part = range ? *range : ByteRange{0, size};
  std::string fields = "Content-Type: " + std::string(media_type(name)) +
                       "\r\nAccept-Ranges: bytes\r\nContent-Length: " + std::to_string(part.bytes) +
                       "\r\n";
  if (range)
    fields += "Content-Range: bytes " + std::to_string(part.first) + "-" +
              std::to_string(part.first + part.bytes - 1) + total;
  WebAnswer answer = answer_of(range ? "206 Partial Content" : "200 OK", fields, closes);
  if (is_head) return answer;
  answer.file = name;
  answer.first = part.first;
  answer.bytes = part.bytes;
  return answer;
}

}  // namespace

WebAnswer answer_request(
    std::string_view head,
    const std::function<std::optional<std::uint64_t>(const std::string&)>& size_of) {
  const std::string_view line = head.substr(0, head.find("\r\n"));
  const std::size_t first_space = line.find(' '), last_space = line.rfind(' ');
  const std::string_view version =
      last_space == std::string_view::npos ? "" : line.substr(last_space + 1);
  if (first_space == last_space || !version.starts_with("HTTP/1.") ||
      head.size() > kMostRequestBytes)
    return refusal("400 Bad Request", false, true);
  const std::string_view method = line.substr(0, first_space);
  std::string_view target = line.substr(first_space + 1, last_space - first_space - 1);
  const bool is_head = method == "HEAD";
  // A body would be taken for the next request.
  const bool has_body =
      !field(head, "Transfer-Encoding").empty() ||
      (!field(head, "Content-Length").empty() && field(head, "Content-Length") != "0");
  const bool closes =
      version != "HTTP/1.1" || has_body || same_word(field(head, "Connection"), "close");
  if (!is_loopback(field(head, "Host"))) return refusal("403 Forbidden", is_head, closes);
  if (method != "GET" && !is_head)
    return refusal("405 Method Not Allowed", false, true, "Allow: GET, HEAD\r\n");
  target = target.substr(0, target.find_first_of("?#"));
  std::string name =
      target == "/" ? "index.html" : std::string(target.substr(target.empty() ? 0 : 1));
  if (!target.starts_with('/') || !is_plain_name(name))
    return refusal("404 Not Found", is_head, closes);
  const std::optional<std::uint64_t> size = size_of(name);
  if (!size) return refusal("404 Not Found", is_head, closes);
  return file_answer(head, name, *size, is_head, closes);
}

}  // namespace orbweave
