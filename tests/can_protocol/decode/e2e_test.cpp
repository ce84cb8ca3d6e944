// End-to-end protection: the published vectors, every state, every refusal.
#include "can_protocol/decode/e2e.hpp"

#include <map>
#include <numeric>
#include <sstream>
#include <tuple>

#include "tests/scratch.hpp"
#include "tests/table.hpp"

namespace odomd::can::e2e_test {
namespace {

using Payload = std::array<std::uint8_t, 8>;

Message message() {
  return parse_dbc(R"(BO_ 1 A: 8 X
 SG_ CRC : 0|8@1+ (1,0) [0|0] "" X
 SG_ Counter : 8|4@1+ (1,0) [0|0] "" X
 SG_ Value : 16|16@1- (1,0) [0|0] "" X
 SG_ BigCrc : 63|8@0+ (1,0) [0|0] "" X
 SG_ HighCounter : 15|4@0+ (1,0) [0|0] "" X
 SG_ SkewCounter : 10|4@1+ (1,0) [0|0] "" X
 SG_ Wide : 32|3@1+ (1,0) [0|0] "" X
)",
                   "a.dbc")
      .messages[0];
}

E2eBinding binding(E2eProfile profile) {
  return {.message = "A",
          .profile = profile,
          .data_id = 0x123,
          .data_id_list = std::vector<std::uint8_t>(16),
          .crc_signal = "CRC",
          .counter_signal = "Counter"};
}

/// Bytes 0 and 1 of a zero payload after protecting `frames` frames.
std::pair<int, int> head(const E2eBinding& from, int frames, Payload payload = {}) {
  const E2eProtection protection(message(), from);
  E2eState state;
  for (int i = 0; i < frames; ++i) protection.protect(payload, state);
  return {payload[0], payload[1]};
}

using Head = std::pair<int, int>;

TEST(E2eProtect, YieldsThePublishedVectorsOfProfile1And11) {
  for (const E2eProfile profile : {E2eProfile::p01, E2eProfile::p11})
    for (const auto& [mode, first, second] :
         {std::tuple{DataIdMode::both, Head{0xCC, 0x00}, Head{0x91, 0x01}},
          {DataIdMode::nibble, Head{0x2A, 0x10}, Head{0x77, 0x11}},
          {DataIdMode::alternating, Head{0xCE, 0x00}, Head{0x02, 0x01}},
          {DataIdMode::low, Head{0xCE, 0x00}, Head{0x93, 0x01}}}) {
      E2eBinding with = binding(profile);
      with.data_id_mode = mode;
      EXPECT_EQ(head(with, 1), first);
      EXPECT_EQ(head(with, 2), second);
    }
}

TEST(E2eProtect, YieldsThePublishedVectorsOfProfile2And22) {
  for (const E2eProfile profile : {E2eProfile::p02, E2eProfile::p22}) {
    E2eBinding with = binding(profile);
    EXPECT_EQ(head(with, 2), (Head{0x45, 0x01}));
    std::iota(with.data_id_list.begin(), with.data_id_list.end(), std::uint8_t{0});
    const Payload rising{0, 1, 2, 3, 4, 5, 6, 7};
    EXPECT_EQ(head(with, 2, rising), (Head{0x61, 0x01}));
    EXPECT_EQ(head(with, 3, rising), (Head{0xBC, 0x02}));
    std::iota(with.data_id_list.begin(), with.data_id_list.end(), std::uint8_t{1});
    EXPECT_EQ(head(with, 2), (Head{0x1B, 0x01}));
    EXPECT_EQ(head(with, 3), (Head{0x98, 0x02}));
  }
}

TEST(E2eProtect, CounterWrapsInEachProfile) {
  for (const auto& [profile, last] :
       {std::pair{E2eProfile::p01, 14}, {E2eProfile::p22, 15}, {E2eProfile::counter, 15}}) {
    E2eBinding with = binding(profile);
    if (profile == E2eProfile::counter) with.crc_signal.clear();
    EXPECT_EQ(head(with, last + 1).second, last);
    EXPECT_EQ(head(with, last + 2).second, 0);
  }
}

/// Every profile, with CRC and counter at different positions.
std::vector<E2eBinding> every_kind() {
  std::vector<E2eBinding> kinds;
  for (const E2eProfile profile :
       {E2eProfile::p01, E2eProfile::p02, E2eProfile::p11, E2eProfile::p22, E2eProfile::sae_j1850})
    kinds.push_back(binding(profile));
  for (const DataIdMode mode : {DataIdMode::alternating, DataIdMode::low, DataIdMode::nibble}) {
    kinds.push_back(binding(E2eProfile::p01));
    kinds.back().data_id_mode = mode;
  }
  kinds.push_back(kinds.back());
  kinds.back().crc_signal = "BigCrc";
  kinds.back().counter_signal = "HighCounter";
  return kinds;
}

TEST(E2eCheck, AcceptsProtectedPayloadsAndRejectsEveryFlippedBit) {
  for (const E2eBinding& kind : every_kind()) {
    const E2eProtection protection(message(), kind);
    E2eState sender;
    E2eState receiver;
    Payload payload{0, 0, 9, 8, 7, 6, 5, 4};
    for (int frame = 0; frame < 40; ++frame) {
      protection.protect(payload, sender);
      for (unsigned bit = 0; bit < 64; ++bit) {
        Payload flipped = payload;
        flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
        EXPECT_EQ(protection.check(flipped, receiver), E2eStatus::error);
      }
      EXPECT_EQ(protection.check(payload, receiver), E2eStatus::ok);
    }
  }
}

/// A sender and a receiver of protected frames.
class E2eSequence : public testing::Test {
 protected:
  /// Checks the sender's next frame after `lost` frames were lost.
  E2eStatus next(int lost = 0) {
    old_ = payload_;
    for (int i = 0; i <= lost; ++i) protection_.protect(payload_, sender_);
    return check(payload_);
  }
  E2eStatus check(std::span<const std::uint8_t> payload) {
    return protection_.check(payload, receiver_);
  }
  /// "3": the next frame after 3 lost ones; "again", "older", "broken", "short", "empty".
  E2eStatus frame(const std::string& kind) {
    Payload broken = payload_;
    broken[5] ^= 0x10U;
    return kind == "again"    ? check(payload_)
           : kind == "older"  ? check(old_)
           : kind == "broken" ? check(broken)
           : kind == "short"  ? check(std::span(payload_).first(7))
           : kind == "empty"  ? check({})
                              : next(std::stoi(kind));
  }

  E2eProtection protection_{message(), binding(E2eProfile::p01)};
  E2eState sender_;
  E2eState receiver_;
  Payload payload_{};
  Payload old_{};
};

TEST_F(E2eSequence, GivesEveryFrameItsStatus) {
  const std::map<E2eStatus, std::string> names{{E2eStatus::ok, "ok "},
                                               {E2eStatus::ok_some_lost, "some_lost "},
                                               {E2eStatus::repeated, "repeated "},
                                               {E2eStatus::wrong_sequence, "wrong_sequence "},
                                               {E2eStatus::error, "error "},
                                               {E2eStatus::no_new_data, "no_new_data "}};
  for_each_row(R"(
# The first frame is taken whatever its counter; a step of 3 is the default limit.
9 -> ok
0 1 2 3 -> ok some_lost some_lost wrong_sequence
0 again again 0 -> ok repeated repeated ok
0 0 older -> ok ok wrong_sequence
# Neither a broken nor a short frame moves the reference.
0 broken again 0 -> ok error repeated ok
0 short empty 0 -> ok error no_new_data ok
)",
               [&](const std::string& frames, const std::string& expected) {
                 sender_ = receiver_ = {};
                 payload_ = {};
                 std::string statuses;
                 std::istringstream words(frames);
                 for (std::string word; words >> word;) statuses += names.at(frame(word));
                 EXPECT_EQ(statuses, expected + ' ') << frames;
               });
}

TEST_F(E2eSequence, RecoversFromAnyLossWithTheNextFrame) {
  for (int lost = 0; lost < 40; ++lost) {
    (void)next(lost);
    EXPECT_EQ(next(), E2eStatus::ok) << lost;
  }
}

TEST_F(E2eSequence, IgnoresPadding) {
  protection_.protect(payload_, sender_);
  std::array<std::uint8_t, 12> padded{};
  std::copy(payload_.begin(), payload_.end(), padded.begin());
  padded[9] = 0x55;
  EXPECT_EQ(check(padded), E2eStatus::ok);
}

TEST_F(E2eSequence, RefusesTheCounterThatProfile1Reserves) {
  payload_[1] = 15;
  const std::uint8_t crc = CrcJ1850::update(CrcJ1850::update(0, std::uint8_t{0x23}), 0x01);
  payload_[0] = CrcJ1850::update(crc, std::span(payload_).subspan(1));
  EXPECT_EQ(check(payload_), E2eStatus::error);
}

TEST(E2ePlain, CounterAloneChecksTheSequenceOnly) {
  E2eBinding plain = binding(E2eProfile::counter);
  plain.crc_signal.clear();
  plain.counter_signal = "Wide";  // three bits
  const E2eProtection protection(message(), plain);
  E2eState state;
  Payload payload{};
  for (const auto& [counter, status] : {std::pair{6, E2eStatus::ok},
                                        {7, E2eStatus::ok},
                                        {0, E2eStatus::ok},
                                        {0, E2eStatus::repeated},
                                        {3, E2eStatus::ok_some_lost},
                                        {2, E2eStatus::wrong_sequence}}) {
    payload[4] = static_cast<std::uint8_t>(counter);
    payload[2] ^= 0xFFU;  // other bytes may change
    EXPECT_EQ(protection.check(payload, state), status);
  }
}

TEST(E2ePlain, ChecksumAloneNeedsNoCounter) {
  E2eBinding plain = binding(E2eProfile::sae_j1850);
  plain.counter_signal.clear();
  const E2eProtection protection(message(), plain);
  E2eState state;
  Payload payload{0, 1, 2, 3, 4, 5, 6, 7};
  protection.protect(payload, state);
  EXPECT_EQ(payload[0], CrcJ1850::update(0xFF, std::span(payload).subspan(1)) ^ 0xFF);
  EXPECT_EQ(payload[1], 1);
  EXPECT_EQ(protection.check(payload, state), E2eStatus::ok);
  EXPECT_EQ(protection.check(payload, state), E2eStatus::ok);
  payload[7] = 0;
  EXPECT_EQ(protection.check(payload, state), E2eStatus::error);
}

TEST(E2eBindingErrors, NameMessageSignalAndFix) {
  struct {
    void (*change)(E2eBinding&);
    const char* error;
  } const cases[]{
      {[](auto& b) { b.crc_signal = "CRCC"; },
       "message 'A': crc signal 'CRCC' is not one of its signals; the nearest is 'CRC'"},
      {[](auto& b) { b.crc_signal.clear(); }, "no crc signal is named"},
      {[](auto& b) { b.counter_signal.clear(); }, "no counter signal is named"},
      {[](auto& b) { b.crc_signal = "Counter"; }, "'Counter' is not a whole byte"},
      {[](auto& b) { b.counter_signal = "Wide"; }, "'Wide' has 3 bits instead of 4"},
      {[](auto& b) { b.counter_signal = "Value"; }, "'Value' is not an unsigned integer"},
      {[](auto& b) { b.max_delta_counter = 0; }, "max_delta_counter is 0"},
      {[](auto& b) { b.data_id_mode = DataIdMode::nibble, b.data_id = 0x1234; },
       "wider than the 12 bits"},
      {[](auto& b) { b.data_id_mode = DataIdMode::nibble, b.counter_signal = "SkewCounter"; },
       "'SkewCounter' is not half a byte"},
      {[](auto& b) { b.profile = E2eProfile::p22, b.data_id_list.resize(15); },
       "data_id_list has 15 entries instead of 16"},
      {[](auto& b) { b.profile = E2eProfile::counter; }, "a plain counter has no crc signal"},
  };
  for (const auto& [change, error] : cases) {
    E2eBinding changed = binding(E2eProfile::p01);
    change(changed);
    EXPECT_THAT(message_of([&] { const E2eProtection taken(message(), changed); }),
                HasSubstr(error));
  }
}

}  // namespace
}  // namespace odomd::can::e2e_test
