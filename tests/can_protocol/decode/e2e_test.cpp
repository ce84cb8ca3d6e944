// End-to-end protection: the published vectors, every state, every refusal.
#include "can_protocol/decode/e2e.hpp"

#include <numeric>

#include "can_protocol/decode/crc8.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

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
  E2eBinding result;
  result.message = "A";
  result.profile = profile;
  result.data_id = 0x123;
  result.crc_signal = "CRC";
  result.counter_signal = "Counter";
  result.data_id_list.resize(16);
  return result;
}

/// Bytes 0 and 1 of a zero payload after protecting `frames` frames.
std::pair<int, int> head(const E2eBinding& from, int frames, Payload payload = {}) {
  const E2eProtection protection(message(), from);
  E2eState state;
  for (int i = 0; i < frames; ++i) protection.protect(payload, state);
  return {payload[0], payload[1]};
}

using Head = std::pair<int, int>;

TEST(Crc8, HasTheCheckValuesOfItsCatalogue) {
  const std::string text = "123456789";
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  EXPECT_EQ(CrcJ1850::update(0xFF, bytes) ^ 0xFF, 0x4B);  // CRC-8/SAE-J1850
  EXPECT_EQ(CrcH2f::update(0xFF, bytes) ^ 0xFF, 0xDF);    // CRC-8/AUTOSAR
}

TEST(E2eProtect, YieldsThePublishedVectorsOfProfile1And11) {
  for (const E2eProfile profile : {E2eProfile::p01, E2eProfile::p11}) {
    E2eBinding with = binding(profile);
    EXPECT_EQ(head(with, 1), (Head{0xCC, 0x00}));
    EXPECT_EQ(head(with, 2), (Head{0x91, 0x01}));
    with.data_id_mode = DataIdMode::nibble;
    EXPECT_EQ(head(with, 1), (Head{0x2A, 0x10}));
    EXPECT_EQ(head(with, 2), (Head{0x77, 0x11}));
    with.data_id_mode = DataIdMode::alternating;
    EXPECT_EQ(head(with, 1), (Head{0xCE, 0x00}));
    EXPECT_EQ(head(with, 2), (Head{0x02, 0x01}));
    with.data_id_mode = DataIdMode::low;
    EXPECT_EQ(head(with, 1), (Head{0xCE, 0x00}));
    EXPECT_EQ(head(with, 2), (Head{0x93, 0x01}));
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

TEST(E2eProtect, CountsRoundInEachProfile) {
  EXPECT_EQ(head(binding(E2eProfile::p01), 15).second, 14);
  EXPECT_EQ(head(binding(E2eProfile::p01), 16).second, 0);
  EXPECT_EQ(head(binding(E2eProfile::p22), 16).second, 15);
  EXPECT_EQ(head(binding(E2eProfile::p22), 17).second, 0);
  E2eBinding plain = binding(E2eProfile::counter);
  plain.crc_signal.clear();
  EXPECT_EQ(head(plain, 16).second, 15);
  EXPECT_EQ(head(plain, 17).second, 0);
}

TEST(E2eProtect, LeavesTheRestOfThePayloadAlone) {
  for (const E2eProfile profile : {E2eProfile::p01, E2eProfile::p22, E2eProfile::sae_j1850}) {
    const E2eProtection protection(message(), binding(profile));
    E2eState state;
    Payload payload{0xFF, 0xAF, 1, 2, 3, 4, 5, 6};
    protection.protect(payload, state);
    EXPECT_EQ(payload[1], 0xA0);
    for (std::size_t i = 2; i < 8; ++i) EXPECT_EQ(payload[i], i - 1);
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

TEST(E2eCheck, AcceptsWhatItsOwnSideProtectsAndNothingThatIsFlippedOnTheWay) {
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

TEST(E2eCheck, FindsAnotherMessagesDataId) {
  for (const E2eBinding& kind : every_kind()) {
    if (kind.profile == E2eProfile::sae_j1850) continue;  // has no data id
    E2eBinding other = kind;
    other.data_id = 0x245;
    other.data_id_list.assign(16, 7);
    E2eState sender;
    E2eState receiver;
    Payload payload{};
    E2eProtection(message(), other).protect(payload, sender);
    EXPECT_EQ(E2eProtection(message(), kind).check(payload, receiver), E2eStatus::error);
  }
}

class E2eSequence : public testing::Test {
 protected:
  explicit E2eSequence(E2eProfile profile = E2eProfile::p01)
      : protection_(message(), binding(profile)) {}

  /// Checks the sender's next frame, after `lost` lost ones.
  E2eStatus next(int lost = 0) {
    for (int i = 0; i <= lost; ++i) protection_.protect(payload_, sender_);
    return protection_.check(payload_, receiver_);
  }
  E2eStatus again() { return protection_.check(payload_, receiver_); }

  E2eProtection protection_;
  E2eState sender_;
  E2eState receiver_;
  Payload payload_{};
};

TEST_F(E2eSequence, TakesTheFirstFrameWhateverItsCounter) {
  EXPECT_EQ(next(9), E2eStatus::ok);
}

TEST_F(E2eSequence, IsOkRoundAndRound) {
  for (int i = 0; i < 50; ++i) EXPECT_EQ(next(), E2eStatus::ok);
}

TEST_F(E2eSequence, DistinguishesSmallFromLargeLosses) {
  (void)next();
  EXPECT_EQ(next(1), E2eStatus::ok_some_lost);
  EXPECT_EQ(next(2), E2eStatus::ok_some_lost);  // step 3, the default limit
  EXPECT_EQ(next(3), E2eStatus::wrong_sequence);
}

TEST_F(E2eSequence, RecoversFromAnyLossWithTheNextFrame) {
  for (int lost = 0; lost < 40; ++lost) {
    (void)next(lost);
    EXPECT_EQ(next(), E2eStatus::ok) << lost;
  }
}

TEST_F(E2eSequence, RefusesARepeatedFrameAndGoesOn) {
  (void)next();
  EXPECT_EQ(again(), E2eStatus::repeated);
  EXPECT_EQ(again(), E2eStatus::repeated);
  EXPECT_EQ(next(), E2eStatus::ok);
}

TEST_F(E2eSequence, RefusesAnOlderFrame) {
  (void)next();
  const Payload old = payload_;
  (void)next();
  EXPECT_EQ(protection_.check(old, receiver_), E2eStatus::wrong_sequence);
}

TEST_F(E2eSequence, IsNotMovedByAFrameInError) {
  (void)next();
  Payload broken = payload_;
  broken[5] ^= 0x10U;
  EXPECT_EQ(protection_.check(broken, receiver_), E2eStatus::error);
  EXPECT_EQ(again(), E2eStatus::repeated);  // the reference is still the last good one
  EXPECT_EQ(next(), E2eStatus::ok);
}

TEST_F(E2eSequence, ReportsShortAndEmptyPayloads) {
  (void)next();
  EXPECT_EQ(protection_.check(std::span(payload_).first(7), receiver_), E2eStatus::error);
  EXPECT_EQ(protection_.check({}, receiver_), E2eStatus::no_new_data);
  EXPECT_EQ(next(), E2eStatus::ok);
}

TEST_F(E2eSequence, DoesNotLookAtPadding) {
  protection_.protect(payload_, sender_);
  std::array<std::uint8_t, 12> padded{};
  std::copy(payload_.begin(), payload_.end(), padded.begin());
  padded[9] = 0x55;
  EXPECT_EQ(protection_.check(padded, receiver_), E2eStatus::ok);
}

TEST_F(E2eSequence, RefusesTheCounterThatProfile1Reserves) {
  payload_[1] = 15;
  const std::uint8_t crc = CrcJ1850::update(CrcJ1850::update(0, std::uint8_t{0x23}), 0x01);
  payload_[0] = CrcJ1850::update(crc, std::span(payload_).subspan(1));
  EXPECT_EQ(again(), E2eStatus::error);
}

TEST(E2ePlain, CounterAloneSeesSequenceOnly) {
  E2eBinding plain = binding(E2eProfile::counter);
  plain.crc_signal.clear();
  plain.counter_signal = "Wide";  // three bits
  const E2eProtection protection(message(), plain);
  E2eState state;
  Payload payload{};
  const auto check = [&](std::uint8_t counter) {
    payload[4] = counter;
    payload[2] ^= 0xFFU;  // other bytes may change
    return protection.check(payload, state);
  };
  EXPECT_EQ(check(6), E2eStatus::ok);
  EXPECT_EQ(check(7), E2eStatus::ok);
  EXPECT_EQ(check(0), E2eStatus::ok);
  EXPECT_EQ(check(0), E2eStatus::repeated);
  EXPECT_EQ(check(3), E2eStatus::ok_some_lost);
  EXPECT_EQ(check(2), E2eStatus::wrong_sequence);
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
