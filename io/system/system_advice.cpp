#include "io/system/system_advice.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace orbweave {
namespace {

std::string as_sentence(std::string text) {
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// Whether advice_on() says how the same place can be used again.
bool keeps_the_place(int error) {
  constexpr std::array kMendable = {0,      ENOSPC, EDQUOT, EFBIG,  EMFILE,
                                    ENFILE, ENOMEM, EAGAIN, EACCES, EPERM};
  return std::find(kMendable.begin(), kMendable.end(), error) != kMendable.end();
}

}  // namespace

std::string advice_on(int error, const std::string& elsewhere) {
  switch (error) {
    case 0:  // HDF5 does not say
    case ENOSPC:
      return "Free some space or " + elsewhere;
    case EDQUOT:
      return "The quota is used up: remove some files there or " + elsewhere;
    case EFBIG:
      return "Raise the limit of file sizes (ulimit -f) or " + elsewhere;
    case EMFILE:
      return "Raise the limit of open files (ulimit -n) or give fewer threads";
    case ENFILE:
      return "The system has no open files left: end other programs or raise its limit";
    case ENOMEM:
      return "Give a smaller memory budget or fewer threads, or raise the limit of memory "
             "(ulimit -v)";
    case EAGAIN:
      return "Give fewer threads or raise the limit of processes (ulimit -u)";
    case EACCES:
    case EPERM:
      return "Change the permissions there or " + elsewhere;
    case EROFS:
      return "That file system is for reading only: " + elsewhere;
    case EIO:
      return "The device fails, the system's log says more: " + elsewhere;
    default:
      return as_sentence(elsewhere);
  }
}

std::string advice_on_work_directory(int error) {
  const std::string advice = advice_on(error, "name another work directory");
  // What is done is in this work directory, and no other one.
  return keeps_the_place(error) ? advice + "; the same command resumes what is done" : advice;
}

bool is_lack(int error) {
  return error == EMFILE || error == ENFILE || error == ENOMEM || error == EAGAIN;
}

bool is_failure(int error) {
  constexpr std::array kFailures = {EIO,          ESTALE,   ETIMEDOUT, EHOSTDOWN,
                                    EHOSTUNREACH, ENETDOWN, ENOTCONN,  EREMOTEIO};
  return std::find(kFailures.begin(), kFailures.end(), error) != kFailures.end();
}

bool is_lack_of_threads(const std::exception& error) {
  const auto* const refusal = dynamic_cast<const std::system_error*>(&error);
  const bool is_of_files =
      dynamic_cast<const std::filesystem::filesystem_error*>(&error) != nullptr;
  if (refusal != nullptr && !is_of_files)
    return refusal->code() == std::errc::resource_unavailable_try_again;
  return std::string_view(error.what()).find("pthread_create") != std::string_view::npos;
}

}  // namespace orbweave
