#include "engine/normals/orientation_graph.h"

#include <oneapi/tbb/parallel_sort.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <span>
#include <tuple>
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
  if (x.a != y.a) return x.a < y.a;
  if (x.b != y.b) return x.b < y.b;
  const double size_x = std::abs(x.votes), size_y = std::abs(y.votes);
  return std::tie(size_x, x.votes, x.weight) < std::tie(size_y, y.votes, y.weight);
};

/// By one of their nodes, in time that is proportional to them; those with the same node stay in
/// their order.
void sort_by_node(std::uint32_t nodes, std::uint32_t SignedEdge::*node,
                  std::vector<SignedEdge>& edges) {
  std::vector<std::uint32_t> next(nodes + 1, 0);
  for (const SignedEdge& e : edges) ++next[e.*node + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<SignedEdge> sorted(edges.size());
  for (const SignedEdge& e : edges) sorted[next[e.*node]++] = e;
  edges.swap(sorted);
}

/// By their nodes, and then the few between the same two.
void sort_few(std::uint32_t nodes, std::vector<SignedEdge>& edges) {
  sort_by_node(nodes, &SignedEdge::b, edges);
  sort_by_node(nodes, &SignedEdge::a, edges);
  for (auto begin = edges.begin(); begin != edges.end();) {
    auto end = begin + 1;
    while (end != edges.end() && end->a == begin->a && end->b == begin->b) ++end;
    if (end - begin > 1) std::sort(begin, end, before);
    begin = end;
  }
}

constexpr std::size_t kFew = std::size_t{1} << 14;

/// Sorts by all threads where there are many items. A caller may be using scratch of its thread:
/// isolated, the thread takes up no other work of the caller while it waits.
template <class T, class Less>
void sort_isolated(std::vector<T>& items, Less less) {
  if (items.size() <= kFew) return std::sort(items.begin(), items.end(), less);
  tbb::this_task_arena::isolate([&] { tbb::parallel_sort(items.begin(), items.end(), less); });
}

/// Sorted by (a, b) with a < b, parallel ones added up.
void normalize(std::uint32_t nodes, std::vector<SignedEdge>& edges) {
  std::erase_if(edges, [](const SignedEdge& e) { return e.a == e.b; });
  for (SignedEdge& e : edges)
    if (e.b < e.a) std::swap(e.a, e.b);
  if (edges.size() <= kFew && nodes <= kFew)
    sort_few(nodes, edges);
  else
    sort_isolated(edges, before);
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

/// The votes of pairs of nodes, by the nodes of a pair in either order: a hash table with open
/// addresses, half of them free.
class PairTable {
 public:
  explicit PairTable(std::size_t pairs) { resize(pairs); }

  /// Null where the pair has none.
  Votes* find(std::uint32_t a, std::uint32_t b) {
    Slot& slot = slots_[place_of(key_of(a, b))];
    return slot.key == kFree || slot.is_erased ? nullptr : &slot.votes;
  }

  /// A pair that was never there has votes of 0, and is new. Ends what find() returned.
  std::pair<Votes*, bool> find_or_add(std::uint32_t a, std::uint32_t b) {
    if (2 * taken_ >= slots_.size()) resize(2 * (taken_ - erased_));
    const std::uint64_t key = key_of(a, b);
    Slot& slot = slots_[place_of(key)];
    const bool is_new = slot.key == kFree;
    if (is_new) {
      slot.key = key;
      ++taken_;
    }
    return {&slot.votes, is_new};
  }

  /// For good: one of the two nodes is no root any more.
  void erase(std::uint32_t a, std::uint32_t b) {
    slots_[place_of(key_of(a, b))].is_erased = true;
    ++erased_;
  }

 private:
  static constexpr std::uint64_t kFree = std::numeric_limits<std::uint64_t>::max();
  struct Slot {
    std::uint64_t key = kFree;
    Votes votes;
    bool is_erased = false;
  };

  static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
  }

  /// Of the key, or a free one where it belongs.
  std::size_t place_of(std::uint64_t key) const {
    // Fibonacci hashing: Knuth, The Art of Computer Programming, volume 3, section 6.4.
    std::size_t place = (key * 0x9e3779b97f4a7c15U) >> shift_;
    while (slots_[place].key != key && slots_[place].key != kFree)
      place = (place + 1) & (slots_.size() - 1);
    return place;
  }

  void resize(std::size_t pairs) {
    const std::size_t size = std::bit_ceil(std::max<std::size_t>(4 * pairs, 8));
    const std::vector<Slot> old = std::exchange(slots_, std::vector<Slot>(size));
    shift_ = 64 - std::countr_zero(size);
    taken_ = erased_ = 0;
    for (const Slot& slot : old) {
      if (slot.key == kFree || slot.is_erased) continue;
      slots_[place_of(slot.key)] = slot;
      ++taken_;
    }
  }

  std::vector<Slot> slots_;
  int shift_ = 0;
  std::size_t taken_ = 0;   // slots that are not free
  std::size_t erased_ = 0;  // of them
};

/// The nodes that each node has votes with, and some that are no roots any more.
class Neighbors {
 public:
  Neighbors(std::uint32_t nodes, std::size_t pairs) : last_(nodes, kNone), degree_(nodes, 0) {
    links_.reserve(2 * pairs);
  }

  void add(std::uint32_t of, std::uint32_t node) {
    links_.push_back({node, last_[of]});
    last_[of] = static_cast<std::uint32_t>(links_.size() - 1);
    ++degree_[of];
  }
  /// Says that one of them is no root any more.
  void lose_one(std::uint32_t of) { --degree_[of]; }
  /// Those that are roots.
  std::uint32_t degree(std::uint32_t of) const { return degree_[of]; }

  /// Calls visit(node) for each, in no order; visit may add.
  template <class Visit>
  void visit_all(std::uint32_t of, Visit visit) const {
    for (std::uint32_t at = last_[of]; at != kNone;) {
      const Link link = links_[at];
      visit(link.node);
      at = link.before;
    }
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Link {
    std::uint32_t node, before;
  };
  std::vector<Link> links_;
  std::vector<std::uint32_t> last_;
  std::vector<std::uint32_t> degree_;
};

class Agglomeration {
 public:
  Agglomeration(std::uint32_t nodes, std::span<const SignedEdge> edges, const JoinOptions& options)
      : options_(options),
        votes_(edges.size()),
        links_(nodes, edges.size()),
        parent_(nodes),
        turn_(nodes, 0),
        first_(nodes),
        size_(options.sizes) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    std::iota(first_.begin(), first_.end(), 0u);
    given_.reserve(edges.size());
    for (const SignedEdge& e : edges) {
      *votes_.find_or_add(e.a, e.b).first = {e.votes, e.weight};
      links_.add(e.a, e.b);
      links_.add(e.b, e.a);
      if (const auto offer = offer_of(e.a, e.b, {e.votes, e.weight})) given_.push_back(*offer);
    }
    sort_isolated(given_, std::less<Offer>());
  }

  SignedParts run() {
    for (std::size_t taken = 0; !given_.empty() || !offers_.empty(); ++taken) {
      if (taken % kStopBlock == 0) check_stop(options_.stop);
      const Offer offer = take_best();
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

  /// Sorting the given offers at once takes less time than a heap of them, and the heap of the
  /// others stays small.
  Offer take_best() {
    const bool is_given = offers_.empty() || (!given_.empty() && offers_.top() < given_.back());
    const Offer best = is_given ? given_.back() : offers_.top();
    if (is_given)
      given_.pop_back();
    else
      offers_.pop();
    return best;
  }

  std::optional<Offer> offer_of(std::uint32_t a, std::uint32_t b, Votes votes) const {
    const double strength = std::abs(votes.votes);
    if (!(strength > 0.0) || strength < options_.least_share * votes.weight) return std::nullopt;
    const auto [first, second] = std::minmax(first_[a], first_[b]);
    return Offer{strength, first, second, a, b};
  }

  bool is_current(const Offer& offer) {
    if (parent_[offer.a] != offer.a || parent_[offer.b] != offer.b) return false;
    const Votes* const votes = votes_.find(offer.a, offer.b);
    return votes != nullptr && std::abs(votes->votes) == offer.strength;
  }

  /// The part with fewer links goes into the other one and is turned where the votes say so.
  void join(std::uint32_t a, std::uint32_t b) {
    const auto rank = [&](std::uint32_t x) { return std::tuple(links_.degree(x), first_[x]); };
    if (rank(a) > rank(b)) std::swap(a, b);
    const Votes between = *votes_.find(a, b);
    const bool turned = between.votes < 0.0;
    if (!size_.empty()) join_sizes(a, b, between);
    parent_[a] = b;
    turn_[a] = turned ? 1 : 0;
    votes_.erase(a, b);
    links_.lose_one(b);
    first_[b] = std::min(first_[a], first_[b]);
    links_.visit_all(a, [&](std::uint32_t other) {
      if (parent_[other] == other && other != b) move_votes(a, b, other, turned);
    });
  }

  /// Adds the votes between a and another part to those between b and that part.
  void move_votes(std::uint32_t a, std::uint32_t b, std::uint32_t other, bool turned) {
    const Votes votes = *votes_.find(a, other);
    votes_.erase(a, other);
    const double moved = turned ? -votes.votes : votes.votes;
    const auto [to, is_new] = votes_.find_or_add(b, other);
    *to = {to->votes + moved, to->weight + votes.weight};
    links_.lose_one(other);
    if (is_new) {
      links_.add(b, other);
      links_.add(other, b);
    }
    if (const auto offer = offer_of(b, other, *to)) offers_.push(*offer);
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
  PairTable votes_;
  Neighbors links_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint8_t> turn_;    // against the parent
  std::vector<std::uint32_t> first_;  // smallest node of a root's part
  std::vector<double> size_;          // of a root's part; empty where sizes are not asked for
  std::vector<WeakJoin> weak_;
  std::vector<Offer> given_;           // of the edges, the best one last
  std::priority_queue<Offer> offers_;  // of the parts that were joined
};

}  // namespace

SignedParts join_by_votes(std::uint32_t nodes, std::vector<SignedEdge> edges,
                          const JoinOptions& options) {
  normalize(nodes, edges);
  return Agglomeration(nodes, edges, options).run();
}

}  // namespace orbweave
