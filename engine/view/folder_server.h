// A folder on the loopback address, for a browser on this machine.
#pragma once

#include <cstdint>
#include <filesystem>

namespace orbweave {

/// Serves the plain files of one folder at 127.0.0.1 (engine/view/web_request.h). Neither folders
/// in it nor links are followed.
class FolderServer {
 public:
  /// Begins to listen; `port` 0: any that is free. Throws Error (resource) where the port is taken.
  FolderServer(std::filesystem::path folder, std::uint16_t port);
  ~FolderServer();
  FolderServer(const FolderServer&) = delete;
  FolderServer& operator=(const FolderServer&) = delete;

  std::uint16_t port() const { return port_; }
  /// Answers until the process ends: a thread for each connection, at most 64 at once.
  [[noreturn]] void serve() const;

 private:
  std::filesystem::path folder_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace orbweave
