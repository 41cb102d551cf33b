#include "engine/pipeline/team_traffic.h"

#include <nlohmann/json.hpp>

#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

std::string traffic_text(const std::vector<StageFacts>& stages) {
  Json list = Json::array();
  for (const StageFacts& facts : stages)
    list.push_back({facts.name, facts.bytes_read, facts.bytes_written, facts.counter_calls});
  return document_text(list);
}

/// The stages of `text` are among those of the root, in the same order.
void add_traffic(const std::string& text, std::vector<StageFacts>& stages) {
  auto stage = stages.begin();
  for (const Json& facts : document_from(text)) {
    while (stage != stages.end() && stage->name != facts.at(0).get<std::string>()) ++stage;
    if (stage == stages.end()) return;
    stage->bytes_read += facts.at(1).get<std::uint64_t>();
    stage->bytes_written += facts.at(2).get<std::uint64_t>();
    stage->counter_calls += facts.at(3).get<std::uint64_t>();
    ++stage;
  }
}

}  // namespace

void gather_traffic(StageRunner& runner) {
  const std::vector<std::string> all =
      runner.communicator.gather(traffic_text(runner.measured), runner.stop);
  for (std::size_t rank = 1; rank < all.size(); ++rank) add_traffic(all[rank], runner.measured);
}

}  // namespace orbweave
