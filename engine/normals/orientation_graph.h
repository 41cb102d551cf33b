// Signs of the nodes of a graph whose edges carry signed votes.
#pragma once

#include <cstdint>
#include <vector>

#include "io/stop_token.h"

namespace orbweave {

struct SignedEdge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  double votes = 0.0;   ///< > 0: a and b are to have the same sign
  double weight = 0.0;  ///< at least |votes|; both relative to other edges only
};

/// Two large parts that were joined although the votes between them contradict each other.
struct WeakJoin {
  std::uint32_t node = 0;  ///< the smallest node of the smaller part
  double size = 0.0;       ///< of the smaller part
};

/// A node's part and whether it is turned against the part's first node.
struct SignedParts {
  std::vector<std::uint32_t> part;  ///< the smallest node that edges connect it with
  std::vector<std::uint8_t> turn;   ///< 0 for the part's smallest node
  std::vector<WeakJoin> weak;       ///< in the order of joining
};

struct JoinOptions {
  double least_share = 0.0;     ///< pairs whose sum is less than so much of its weight stay apart
  std::vector<double> sizes{};  ///< of the nodes; empty: weak joins are not listed
  double large = 0.0;           ///< weak joins are listed where both parts are so large
  const StopToken* stop = nullptr;  ///< may be null
};

/// Joins the pair of parts with the largest |sum of votes| (of equal ones the pair with the
/// smallest nodes), adds up the votes that become parallel, and repeats: greedy agglomeration as
/// in Keuper, Levinkov, Bonneel, Lavoué, Brox, Andres: Efficient Decomposition of Image and Mesh
/// Graphs by Lifted Multicuts, 2015, section 4, with signs that turn instead of cuts. Pairs whose
/// sum is 0 are not joined. Edges in any order, parallel ones allowed; the result is a function of
/// the edges' sorted list. O(e log^2 e).
SignedParts join_by_votes(std::uint32_t nodes, std::vector<SignedEdge> edges,
                          const JoinOptions& options = {});

}  // namespace orbweave
