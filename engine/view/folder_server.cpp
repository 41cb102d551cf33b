#include "engine/view/folder_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <optional>
#include <semaphore>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "engine/view/web_request.h"
#include "io/error.h"
#include "io/system/file_descriptor.h"

namespace orbweave {
namespace {

constexpr int kMostConnections = 64;
constexpr time_t kIdleSeconds = 30;
constexpr std::size_t kSentAtOnce = std::size_t{1} << 18;

struct OpenedFile {
  FileDescriptor descriptor;
  std::uint64_t bytes = 0;
};

/// `name` has no slash; a link is not followed, a pipe is not waited for.
std::optional<OpenedFile> open_in(const std::filesystem::path& folder, const std::string& name) {
  const FileDescriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!directory.valid()) return std::nullopt;
  OpenedFile file{FileDescriptor(
      ::openat(directory.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC))};
  struct stat facts {};
  if (!file.descriptor.valid() || ::fstat(file.descriptor.get(), &facts) != 0 ||
      !S_ISREG(facts.st_mode))
    return std::nullopt;
  file.bytes = static_cast<std::uint64_t>(facts.st_size);
  return file;
}

bool send_all(int socket, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t sent = ::send(socket, bytes, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool send_file(int socket, const FileDescriptor& file, std::uint64_t first, std::uint64_t count) {
  std::vector<char> buffer(kSentAtOnce);
  while (count > 0) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(count, buffer.size()));
    const ssize_t got = ::pread(file.get(), buffer.data(), wanted, static_cast<off_t>(first));
    if (got < 0 && errno == EINTR) continue;
    // The length was said already: an end of the connection says that less came.
    if (got <= 0 || !send_all(socket, buffer.data(), static_cast<std::size_t>(got))) return false;
    first += static_cast<std::uint64_t>(got);
    count -= static_cast<std::uint64_t>(got);
  }
  return true;
}

/// The head of the next request; what came after it stays in `received`. Empty: no more.
std::string next_head(int socket, std::string& received) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  for (;;) {
    const std::size_t end = received.find(kEnd);
    if (end != std::string::npos) {
      std::string head = received.substr(0, end + kEnd.size());
      received.erase(0, head.size());
      return head;
    }
    if (received.size() > kMostRequestBytes) return std::exchange(received, {});
    char buffer[4096];
    const ssize_t got = ::recv(socket, buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return {};
    received.append(buffer, static_cast<std::size_t>(got));
  }
}

void talk(const FileDescriptor& connection, const std::filesystem::path& folder) {
  const timeval patience{kIdleSeconds, 0};
  ::setsockopt(connection.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(connection.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  std::string received;
  for (;;) {
    const std::string head = next_head(connection.get(), received);
    if (head.empty()) return;
    std::optional<OpenedFile> file;
    const WebAnswer answer =
        answer_request(head, [&](const std::string& name) -> std::optional<std::uint64_t> {
          file = open_in(folder, name);
          if (!file) return std::nullopt;
          return file->bytes;
        });
    const std::string front = answer.head + answer.text;
    if (!send_all(connection.get(), front.data(), front.size())) return;
    if (!answer.file.empty() &&
        !send_file(connection.get(), file->descriptor, answer.first, answer.bytes))
      return;
    if (answer.closes) return;
  }
}

[[noreturn]] void fail_to_listen(std::uint16_t port) {
  const int reason = errno;
  throw_resource("cannot serve at 127.0.0.1:" + std::to_string(port),
                 {.found = std::generic_category().message(reason),
                  .expected = "a port that no other program has",
                  .advice = "Name another port, or 0 for any that is free: --serve=0"});
}

}  // namespace

FolderServer::FolderServer(std::filesystem::path folder, std::uint16_t port)
    : folder_(std::move(folder)) {
  FileDescriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (!listener.valid()) fail_to_listen(port);
  // A port whose last connections just ended is free; one that is listened at is not.
  const int yes = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  socklen_t bytes = sizeof address;
  if (::bind(listener.get(), any, bytes) != 0 || ::listen(listener.get(), kMostConnections) != 0 ||
      ::getsockname(listener.get(), any, &bytes) != 0)
    fail_to_listen(port);
  port_ = ntohs(address.sin_port);
  listener_ = listener.release();
}

FolderServer::~FolderServer() { ::close(listener_); }

void FolderServer::serve() const {
  static std::counting_semaphore<kMostConnections> free_places(kMostConnections);
  for (;;) {
    free_places.acquire();
    // poll() waits, because the thread sanitizer holds signals back while accept4() does.
    pollfd waiting{listener_, POLLIN, 0};
    const int accepted =
        ::poll(&waiting, 1, -1) < 0 ? -1 : ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (accepted < 0) {
      free_places.release();
      // Out of descriptors, perhaps: others end.
      if (errno != EINTR && errno != ECONNABORTED)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      continue;
    }
    try {
      std::thread([accepted, folder = folder_] {
        {
          const FileDescriptor connection(accepted);
          try {
            talk(connection, folder);
          } catch (const std::exception&) {
            // Out of memory: this connection ends, the others go on.
          }
        }
        free_places.release();
      }).detach();
    } catch (const std::system_error&) {
      ::close(accepted);
      free_places.release();
    }
  }
}

}  // namespace orbweave
