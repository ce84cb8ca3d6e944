// The tables of diagnostics, and docs/diagnostics.md, which shows them. ODOMD_WRITE_PAGES=1 writes
// the page.
#include "tests/diagnostics.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>

#include "tools/diagnostics/kinds.hpp"

namespace odomd::diagnostics::diagnostic_test {
namespace {

constexpr auto file = ODOMD_SOURCE_DIR "/docs/diagnostics.md";

std::string usual(const Kind& kind) {
  const Limits& limits = kind.limits;
  const std::string unit = kind.unit.empty() ? "" : " " + std::string{kind.unit};
  const std::string range =
      !std::isfinite(limits.most)    ? fmt::format("at least {:.3g}", limits.least)
      : !std::isfinite(limits.least) ? fmt::format("at most {:.3g}", limits.most)
                                     : fmt::format("{:.3g} to {:.3g}", limits.least, limits.most);
  return fmt::format("{}{}: {}", range, unit, kind.reason);
}

std::string page() {
  std::string text =
      "# Diagnostics\n\n"
      "Each problem that `odomd`, `odom doctor`, `replay`, `evaluate`, `export` and `identify`\n"
      "report ends with its fix and a code. With `--json` the list `diagnostics` has `code`,\n"
      "`name`, `subject`, `seen` and `fix` of each. Entries: meaning, *the fix* (except in W4 and\n"
      "W5, which only tools report), and the limits outside which it is issued. A fix that writes\n"
      "nothing under /etc lasts until the next reboot.\n\n"
      "<!-- Made from tools/diagnostics/kinds.hpp: ODOMD_WRITE_PAGES=1 test_diagnostics -->\n";
  for (const Chapter& chapter : tools::all_chapters) {
    text += fmt::format("\n## {}\n\n", chapter.title);
    for (const Kind& kind : chapter.kinds) {
      std::string fix{kind.fix};
      std::erase_if(fix, [](char one) { return one == '{' || one == '}'; });
      text += fmt::format("- **{}** `{}`: {}", kind.code, kind.name, kind.meaning);
      // Only tools report these kinds, and they print the fix each time.
      const bool is_of_tools = kind.code.starts_with("W4") || kind.code.starts_with("W5");
      if (!fix.empty() && !is_of_tools) text += fmt::format(" *{}*", fix);
      text += kind.limits.exist() ? fmt::format(" ({})\n", usual(kind)) : "\n";
    }
  }
  return text;
}

TEST(Table, HasEveryCodeAndNameOnceInOrder) {
  std::set<std::string_view> names;
  std::string_view before = "W100";
  for (const Chapter& chapter : tools::all_chapters)
    for (const Kind& kind : chapter.kinds) {
      EXPECT_LT(before, kind.code);
      EXPECT_EQ(kind.code.size(), 4U) << kind.code;
      EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
      EXPECT_TRUE(kind.meaning.ends_with('.')) << kind.name;
      EXPECT_EQ(kind.limits.exist(), !kind.reason.empty()) << kind.name;
      EXPECT_LE(kind.limits.least, kind.limits.most) << kind.name;
      before = kind.code;
    }
  EXPECT_GT(names.size(), 80U);
}

TEST(Text, HasSubjectFindingFixAndCode) {
  const Diagnostic gyro =
      found(kind("wrong_sign"), "yaw_rate (IMU)", "the sign is wrong", "can.signals.yaw_rate");
  EXPECT_EQ(text_of(gyro),
            "yaw_rate (IMU): the sign is wrong; check the sign of can.signals.yaw_rate.scale "
            "[W301]");
  EXPECT_EQ(text_of(found(kind("log_content"), "", "drive.log:7: cut off")),
            "drive.log:7: cut off [W201]");
}

TEST(Limits, HoldForValuesWithin) {
  constexpr Limits limits{.least = 0.5, .most = 2.0};
  EXPECT_TRUE(limits.hold(0.5));
  EXPECT_TRUE(limits.hold(2.0));
  EXPECT_FALSE(limits.hold(2.1));
  EXPECT_FALSE(limits.hold(std::nan("")));
  EXPECT_TRUE(Limits{}.hold(1e300));
}

TEST(Page, MatchesTheTable) {
  if (std::getenv("ODOMD_WRITE_PAGES") != nullptr) std::ofstream{file} << page();
  std::ifstream written{file};
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>{written}, {}), page());
}

}  // namespace
}  // namespace odomd::diagnostics::diagnostic_test
