#include "daemon/journal/repeats.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace odomd::daemon::repeats_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::int64_t second = 1'000'000'000;

Message warning(const std::string& text) {
  return {spdlog::level::warn, text};
}

std::vector<std::string> texts(const std::vector<Message>& messages) {
  std::vector<std::string> texts;
  for (const auto& message : messages) texts.push_back(message.text);
  return texts;
}

/// The times [s] at which something is logged of a message every `every` seconds for `length`.
std::vector<std::int64_t> logged(Repeats& repeats, std::int64_t every, std::int64_t length) {
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= length; ++t) {
    if (!repeats.due(t * second).empty()) times.push_back(t);
    if (t % every == 0 && repeats.take(warning("ticks missed: " + std::to_string(t)), t * second))
      times.push_back(t);
  }
  return times;
}

TEST(Repeats, GrowFromASecondToTenMinutes) {
  Repeats repeats;
  EXPECT_THAT(logged(repeats, 1, 2600), ElementsAre(0, 1, 5, 21, 85, 341, 941, 1541, 2141));
}

TEST(Repeats, GrowWhereTheMessageIsSlow) {
  Repeats repeats;
  EXPECT_THAT(logged(repeats, 15, 600), ElementsAre(0, 15, 30, 46, 110, 366));
}

TEST(Repeats, GiveTheNewestTextTheNumberAndTheDuration) {
  Repeats repeats;
  EXPECT_TRUE(repeats.take(warning("ticks missed: 1"), 0));
  EXPECT_FALSE(repeats.take(warning("ticks missed: 2"), second / 4));
  EXPECT_FALSE(repeats.take({spdlog::level::info, "ticks missed: 7"}, second / 2));
  EXPECT_THAT(repeats.due(second - 1), IsEmpty());
  const auto due = repeats.due(3 * second);
  ASSERT_THAT(texts(due), ElementsAre("ticks missed: 7 (2 times in 3 s, the last 2.5 s ago)"));
  EXPECT_EQ(due.front().level, spdlog::level::info);
  EXPECT_THAT(repeats.due(600 * second), IsEmpty());
}

TEST(Repeats, AreNewAgainAfterTenMinutesOfRest) {
  Repeats repeats;
  EXPECT_TRUE(repeats.take(warning("down"), 0));
  EXPECT_TRUE(repeats.take(warning("down"), 2 * second));
  EXPECT_THAT(repeats.due(602 * second), IsEmpty());
  EXPECT_TRUE(repeats.take(warning("down"), 603 * second));
  EXPECT_FALSE(repeats.take(warning("down"), 603 * second));
  EXPECT_THAT(texts(repeats.due(604 * second)), ElementsAre(HasSubstr("(1 time in 1 s")));
}

TEST(Repeats, AreKeptApartByTheirSubjectNotByTheirNumbers) {
  Repeats repeats;
  EXPECT_TRUE(repeats.take(warning("can0: lost 3 frames"), 0));
  EXPECT_TRUE(repeats.take(warning("can1: lost 3 frames"), 0));
  EXPECT_TRUE(repeats.take(warning("1.log: lost 3 frames"), 0));
  EXPECT_TRUE(repeats.take(warning("2.log: lost 3 frames"), 0));
  EXPECT_FALSE(repeats.take(warning("can0: lost 17 frames"), 0));
  EXPECT_TRUE(repeats.take(warning("connected (pid 7, uid 0)"), 0));
  EXPECT_FALSE(repeats.take(warning("connected (pid 81, uid 1000)"), 0));
  EXPECT_TRUE(repeats.take(warning("stepped by +0.500000 s"), 0));
  EXPECT_FALSE(repeats.take(warning("stepped by -1.2e-05 s"), 0));
}

TEST(Repeats, AreAllGivenAtTheEnd) {
  Repeats repeats;
  for (const char* text : {"a", "b", "b", "c", "c", "c"})
    static_cast<void>(repeats.take(warning(text), 0));
  EXPECT_THAT(texts(repeats.rest(second / 2)),
              ElementsAre("b (1 time in 0.5 s)", "c (2 times in 0.5 s)"));
  EXPECT_THAT(repeats.rest(second), IsEmpty());
}

}  // namespace
}  // namespace odomd::daemon::repeats_test
