#include "engine/levels/tileset_work.h"

#include <exception>
#include <string>
#include <utility>

#include "io/error.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

constexpr const char* kStore = "tileset";

}  // namespace

TilesetWork::TilesetWork(std::filesystem::path directory) : directory_(std::move(directory)) {
  std::error_code error;
  std::filesystem::create_directory(directory_, error);
  if (error)
    throw_resource("cannot make the work directory", {.file = directory_.string(),
                                                      .found = error.message(),
                                                      .advice = advice_on(error.value())});
  record_ = std::make_shared<OwnedFiles>(directory_, kStore, 0);
  record_->remove_abandoned();
  scope_.emplace(record_);
}

TilesetWork::~TilesetWork() {
  scope_.reset();
  try {
    record_->close();
    record_->remove_record(directory_ / (std::string(kRecordName) + "0"));
    remove_if_empty(directory_);
  } catch (const std::exception&) {
    // What stays is found by the next run.
  }
}

}  // namespace orbweave
