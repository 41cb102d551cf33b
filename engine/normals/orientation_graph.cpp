#include "engine/normals/orientation_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace orbweave {
namespace {

struct Votes {
  double votes = 0.0;
  double weight = 0.0;
};

/// By size first, so that a node that starts with the other sign has its votes added in the same
/// order.
constexpr auto before = [](const SignedEdge& x, const SignedEdge& y) {
  const double size_x = std::abs(x.votes), size_y = std::abs(y.votes);
  return std::tie(x.a, x.b, size_x, x.votes, x.weight) <
         std::tie(y.a, y.b, size_y, y.votes, y.weight);
};

/// Sorted by (a, b) with a < b, parallel ones added up.
void normalize(std::vector<SignedEdge>& edges) {
  std::erase_if(edges, [](const SignedEdge& e) { return e.a == e.b; });
  for (SignedEdge& e : edges)
    if (e.b < e.a) std::swap(e.a, e.b);
  std::sort(edges.begin(), edges.end(), before);
  std::size_t kept = 0;
  for (const SignedEdge& e : edges) {
    if (kept > 0 && edges[kept - 1].a == e.a && edges[kept - 1].b == e.b) {
      edges[kept - 1].votes += e.votes;
      edges[kept - 1].weight += e.weight;
    } else {
      edges[kept++] = e;
    }
  }
  edges.resize(kept);
}

/// Votes between large parts are to go one way at least this to one against the other.
constexpr double kClear = 3.0;

class Agglomeration {
 public:
  Agglomeration(std::uint32_t nodes, const std::vector<SignedEdge>& edges,
                const JoinOptions& options)
      : options_(options),
        links_(nodes),
        parent_(nodes),
        turn_(nodes, 0),
        first_(nodes),
        size_(options.sizes) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    std::iota(first_.begin(), first_.end(), 0u);
    for (const SignedEdge& e : edges) {
      links_[e.a][e.b] = {e.votes, e.weight};
      links_[e.b][e.a] = {e.votes, e.weight};
      offer(e.a, e.b, {e.votes, e.weight});
    }
  }

  SignedParts run() {
    for (std::size_t taken = 0; !offers_.empty(); ++taken) {
      if (taken % kStopBlock == 0) check_stop(options_.stop);
      const Offer offer = offers_.top();
      offers_.pop();
      if (is_current(offer)) join(offer.a, offer.b);
    }
    return parts();
  }

 private:
  /// `a` and `b` are roots; the pair is told by the smallest nodes of both.
  struct Offer {
    double strength = 0.0;
    std::uint32_t first = 0, second = 0;
    std::uint32_t a = 0, b = 0;
    bool operator<(const Offer& other) const {
      if (strength != other.strength) return strength < other.strength;
      return std::tie(first, second) > std::tie(other.first, other.second);
    }
  };

  void offer(std::uint32_t a, std::uint32_t b, Votes votes) {
    const double strength = std::abs(votes.votes);
    if (!(strength > 0.0) || strength < options_.least_share * votes.weight) return;
    const auto [first, second] = std::minmax(first_[a], first_[b]);
    offers_.push({strength, first, second, a, b});
  }

  bool is_current(const Offer& offer) const {
    if (parent_[offer.a] != offer.a || parent_[offer.b] != offer.b) return false;
    const auto found = links_[offer.a].find(offer.b);
    return found != links_[offer.a].end() && std::abs(found->second.votes) == offer.strength;
  }

  /// The part with fewer links goes into the other one and is turned where the votes say so.
  void join(std::uint32_t a, std::uint32_t b) {
    const auto rank = [&](std::uint32_t x) { return std::tuple(links_[x].size(), first_[x]); };
    if (rank(a) > rank(b)) std::swap(a, b);
    const bool turned = links_[a][b].votes < 0.0;
    if (!size_.empty()) join_sizes(a, b, links_[a][b]);
    parent_[a] = b;
    turn_[a] = turned ? 1 : 0;
    links_[b].erase(a);
    links_[a].erase(b);
    first_[b] = std::min(first_[a], first_[b]);
    for (const auto& [other, votes] : links_[a]) {
      const double moved = turned ? -votes.votes : votes.votes;
      Votes& to = links_[b][other];
      to = {to.votes + moved, to.weight + votes.weight};
      links_[other].erase(a);
      links_[other][b] = to;
      offer(b, other, to);
    }
    links_[a] = {};
  }

  /// `b` stays.
  void join_sizes(std::uint32_t a, std::uint32_t b, Votes votes) {
    const std::uint32_t smaller = size_[a] < size_[b] ? a : b;
    // votes = pro - contra, weight = pro + contra
    const bool is_weak = std::abs(votes.votes) * (kClear + 1.0) < votes.weight * (kClear - 1.0);
    if (is_weak && size_[smaller] >= options_.large)
      weak_.push_back({first_[smaller], size_[smaller]});
    size_[b] += size_[a];
  }

  /// Makes the root the parent of v and of all nodes on the way, which may be very long.
  void link_to_root(std::uint32_t v) {
    std::uint32_t root = v;
    std::uint8_t turn = 0;
    for (; parent_[root] != root; root = parent_[root]) turn ^= turn_[root];
    while (parent_[v] != root && v != root) {
      const std::uint32_t next = parent_[v];
      const std::uint8_t own = turn_[v];
      parent_[v] = root;
      turn_[v] = turn;
      turn ^= own;
      v = next;
    }
  }

  SignedParts parts() {
    const auto nodes = static_cast<std::uint32_t>(parent_.size());
    SignedParts result{std::vector<std::uint32_t>(nodes), std::vector<std::uint8_t>(nodes),
                       std::move(weak_)};
    for (std::uint32_t v = 0; v < nodes; ++v) {
      link_to_root(v);
      result.part[v] = first_[parent_[v]];
      result.turn[v] = turn_[v];
    }
    for (std::uint32_t v = nodes; v-- > 0;)
      if (result.part[v] != v) result.turn[v] ^= result.turn[result.part[v]];
    for (std::uint32_t v = 0; v < nodes; ++v)
      if (result.part[v] == v) result.turn[v] = 0;
    return result;
  }

  const JoinOptions& options_;
  // Only looked up, or each entry treated alone: the order of entries does not matter.
  std::vector<std::unordered_map<std::uint32_t, Votes>> links_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> turn_;    // against the parent
  std::vector<std::uint32_t> first_;  // smallest node of a root's part
  std::vector<double> size_;          // of a root's part; empty where sizes are not asked for
  std::vector<WeakJoin> weak_;
  std::priority_queue<Offer> offers_;
};

}  // namespace

SignedParts join_by_votes(std::uint32_t nodes, std::vector<SignedEdge> edges,
                          const JoinOptions& options) {
  normalize(edges);
  return Agglomeration(nodes, edges, options).run();
}

}  // namespace orbweave
