// The protocol of shm_api/layout/slot.h on a machine that reorders as much as it may, unlike x86:
// two accesses of one thread happen in either order unless the C++ memory model orders them. The
// test tries all orders of writer and reader; no reader may take words of two ticks for one pose.
// If any one of the orderings is left out, a reader does: each is needed. docs/dev/shm-protocol.md
// explains why.
//
// One thread only stores and the other only loads, so this much of the memory model is enough:
// there is one memory, each store happens once, and each load at some instant.
#include <compare>
#include <set>

#include "tests/gtest.hpp"

namespace {

enum class Kind : std::uint8_t { store, load, release_fence, acquire_fence };
enum class Order : std::uint8_t { relaxed, ordered };  // ordered: a release store, an acquire load
enum Location : std::uint8_t { head, sequence, first_word, second_word, locations };

struct Access {
  Kind kind = Kind::load;
  Location location = head;
  int value = 0;  // of a store
  Order order = Order::relaxed;
};
using Thread = std::vector<Access>;

constexpr Access store(Location location, int value, Order order = Order::relaxed) {
  return {Kind::store, location, value, order};
}
constexpr Access load(Location location, Order order = Order::relaxed) {
  return {Kind::load, location, 0, order};
}

bool is_fence(const Access& access) {
  return access.kind == Kind::release_fence || access.kind == Kind::acquire_fence;
}

// Whether access i of a thread must be performed before its later access j.
bool comes_before(const Thread& thread, std::size_t i, std::size_t j) {
  const Access& a = thread[i];
  const Access& b = thread[j];
  if (is_fence(a) || is_fence(b)) return false;  // fences order other accesses
  if (a.location == b.location) return true;
  if (a.kind == Kind::load && a.order == Order::ordered) return true;
  if (b.kind == Kind::store && b.order == Order::ordered) return true;
  for (std::size_t k = i + 1; k < j; ++k) {
    if (thread[k].kind == Kind::release_fence && b.kind == Kind::store) return true;
    if (thread[k].kind == Kind::acquire_fence && a.kind == Kind::load) return true;
  }
  return false;
}

// The orderings of the protocol, with the names of slot.h.
struct Protocol {
  bool w1_is_release_store = false;
  bool w2 = true;
  Order w4 = Order::ordered;
  Order w5 = Order::ordered;
  Order r1 = Order::ordered;
  bool r3 = true;
  Order r4 = Order::relaxed;
};

// Writes ticks 1 and 2 to the same slot, a full round apart. Both words of tick k are k.
Thread writer(const Protocol& protocol) {
  Thread thread;
  for (int tick = 1; tick <= 2; ++tick) {
    thread.push_back(store(sequence, 2 * tick + 1,
                           protocol.w1_is_release_store ? Order::ordered : Order::relaxed));
    if (protocol.w2) thread.push_back({Kind::release_fence});
    thread.push_back(store(first_word, tick));
    thread.push_back(store(second_word, tick));
    thread.push_back(store(sequence, 2 * tick + 2, protocol.w4));
    thread.push_back(store(head, 2 * tick + 2, protocol.w5));
  }
  return thread;
}

Thread reader(const Protocol& protocol) {
  Thread thread{load(head, protocol.r1), load(first_word), load(second_word)};
  if (protocol.r3) thread.push_back({Kind::acquire_fence});
  thread.push_back(load(sequence, protocol.r4));
  return thread;
}

struct State {
  std::array<int, locations> memory{};
  std::array<int, locations> read{};  // values that the reader loaded, each location once
  std::array<std::uint32_t, 2> performed{};
  auto operator<=>(const State&) const = default;
};

struct Outcomes {
  std::set<int> whole;  // ticks that a reader accepted with both words
  bool torn = false;
};

class Machine {
 public:
  explicit Machine(const Protocol& protocol) : threads_{writer(protocol), reader(protocol)} {}

  Outcomes run() {
    explore({});
    return outcomes_;
  }

 private:
  void explore(const State& state) {
    if (!seen_.insert(state).second) return;
    bool done = true;
    for (std::size_t t = 0; t < threads_.size(); ++t)
      for (std::size_t i = 0; i < threads_[t].size(); ++i) {
        if ((state.performed[t] >> i & 1U) != 0) continue;
        done = false;
        if (!is_free(t, i, state)) continue;
        const Access& access = threads_[t][i];
        State next = state;
        next.performed[t] |= 1U << i;
        if (access.kind == Kind::store) next.memory[access.location] = access.value;
        if (access.kind == Kind::load) next.read[access.location] = state.memory[access.location];
        explore(next);
      }
    if (done) judge(state.read);
  }

  [[nodiscard]] bool is_free(std::size_t t, std::size_t i, const State& state) const {
    for (std::size_t before = 0; before < i; ++before)
      if ((state.performed[t] >> before & 1U) == 0 && comes_before(threads_[t], before, i))
        return false;
    return true;
  }

  void judge(const std::array<int, locations>& read) {
    if (read[head] == 0 || read[sequence] != read[head]) return;  // no pose, or rejected
    const int tick = read[head] / 2 - 1;
    if (read[first_word] == tick && read[second_word] == tick)
      outcomes_.whole.insert(tick);
    else
      outcomes_.torn = true;
  }

  std::array<Thread, 2> threads_;
  std::set<State> seen_;
  Outcomes outcomes_;
};

TEST(Ordering, NoReaderTakesWordsOfTwoTicksForOne) {
  const Outcomes outcomes = Machine({}).run();
  EXPECT_FALSE(outcomes.torn);
  EXPECT_EQ(outcomes.whole, (std::set{1, 2})) << "readers take poses at all";
  // Readers that start from the head do not need the release of the sequence.
  EXPECT_FALSE(Machine({.w4 = Order::relaxed}).run().torn);
}

TEST(Ordering, EachIsNeeded) {
  const std::pair<const char*, Protocol> without[]{
      {"W2", {.w2 = false}},
      {"W5", {.w5 = Order::relaxed}},
      {"R1", {.r1 = Order::relaxed}},
      {"R3", {.r3 = false}},
      {"W2, for which a release store of the odd sequence is no substitute",
       {.w1_is_release_store = true, .w2 = false}},
      {"R3, for which an acquire load of the sequence is no substitute",
       {.r3 = false, .r4 = Order::ordered}},
  };
  for (const auto& [what, protocol] : without) EXPECT_TRUE(Machine(protocol).run().torn) << what;
}

}  // namespace
