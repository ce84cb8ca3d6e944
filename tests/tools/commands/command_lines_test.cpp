// The descriptions of the command lines agree with them: each help has an example, and the shells'
// completions offer exactly its options. An error names the first misspelt word and what was
// probably meant.
#include <set>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::command_lines_test {
namespace {

using ::testing::AnyOf;
using ::testing::IsSupersetOf;

struct Command {
  std::string name;  // "odom camera send"
  std::string help;
  std::set<std::string> options;   // with their dashes
  std::set<std::string> commands;  // its subcommands
};

Command command_of(const std::string& name) {
  Command command{name, run_shell(name + " --help").out, {}, {}};
  // Options: "  --can SRC ...", "  -h,--help"; below "Subcommands:", two spaces and a name.
  static const std::regex option(R"(^  (?:(-\w),)?(--[a-z][-a-z0-9]*)\b.*)");
  static const std::regex sub(R"(^  ([a-z]+)  +[A-Z].*)");
  std::istringstream lines{command.help};
  bool subcommands = false;
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (line.empty() || line[0] != ' ') subcommands = line == "Subcommands:";
    if (std::regex_match(line, match, option)) {
      if (match[1].matched) command.options.insert(match[1]);
      command.options.insert(match[2]);
    } else if (subcommands && std::regex_match(line, match, sub)) {
      command.commands.insert(match[1]);
    }
  }
  return command;
}

void add_commands(const std::string& name, std::vector<Command>& all) {
  all.push_back(command_of(name));
  const std::set<std::string> below = all.back().commands;
  for (const std::string& sub : below) add_commands(name + ' ' + sub, all);
}

const std::vector<Command>& all_commands() {
  static const std::vector<Command> commands = [] {
    std::vector<Command> all;
    add_commands("odom", all);
    add_commands("odomd", all);
    return all;
  }();
  return commands;
}

std::string program_of(const Command& command) {
  return command.name.substr(0, command.name.find(' '));
}

// Words that bash offers to complete the last word.
std::set<std::string> offered(const std::string& words, const std::string& before = ":") {
  const std::string program = words.substr(0, words.find(' '));
  const Outcome outcome =
      run_shell("bash --norc -c 'source " ODOMD_COMPLETIONS "/odom.bash; " + before +
                "; COMP_WORDS=(" + words + "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _odom " +
                program + R"(; printf "%s\n" "${COMPREPLY[@]}"')");
  EXPECT_EQ(outcome.status, 0) << words;
  EXPECT_EQ(outcome.err, "") << words;
  std::set<std::string> all;
  std::istringstream lines{outcome.out};
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) all.insert(line);
  return all;
}

TEST(Help, OfEveryCommandHasAnExample) {
  EXPECT_GE(all_commands().size(), 13U);
  for (const Command& command : all_commands()) {
    EXPECT_THAT(command.help, AnyOf(HasSubstr("\nExamples:\n  "), HasSubstr("\nExample:\n  ")))
        << command.name;
    EXPECT_THAT(command.options, IsSupersetOf({"-h", "--help"})) << command.name;
  }
}

TEST(Help, IsWrittenInOneManner) {
  static const std::regex lower(R"(\n  -[^ ]+( [^ ]+)*  +[a-z][^\n]*)");
  for (const Command& command : all_commands()) {
    std::smatch match;
    EXPECT_FALSE(std::regex_search(command.help, match, lower)) << command.name << match[0];
    EXPECT_THAT(command.help, Not(HasSubstr(" TEXT REQUIRED"))) << command.name;
    EXPECT_THAT(command.help, Not(HasSubstr("(default"))) << command.name;
    EXPECT_TRUE(std::ranges::all_of(command.help, [](unsigned char c) {
      return c == '\n' || c >= ' ';
    })) << command.name;
  }
}

TEST(Completions, OfBashOfferEveryOptionAndCommandOfTheHelp) {
  for (const Command& command : all_commands()) {
    EXPECT_EQ(offered(command.name + " -"), command.options) << command.name;
    if (command.commands.empty()) continue;
    std::set<std::string> both = command.options;
    both.insert(command.commands.begin(), command.commands.end());
    EXPECT_EQ(offered(command.name + " \"\""), both) << command.name;
  }
}

TEST(Completions, OfBashOfferValues) {
  using Words = std::set<std::string>;
  EXPECT_EQ(offered("odom pose --clock \"\""), (Words{"monotonic", "realtime", "log"}));
  EXPECT_EQ(offered("odomd --model p"), Words{"paper"});
  EXPECT_EQ(offered("odomd --log-level w"), Words{"warn"});
  EXPECT_EQ(offered("odom sim --scenario st"), Words{"stop-and-go"});
  EXPECT_EQ(offered("odom bridge --rate \"\""), Words{});
  const Scratch scratch;
  scratch.write("car.toml", "");
  scratch.write("drive.log", "");
  const std::string folder = "cd " + scratch.path("").string();
  EXPECT_EQ(offered("odomd --config c", folder), Words{"car.toml"});
  EXPECT_EQ(offered("odom dbc show d", folder), Words{"drive.log"});
  EXPECT_EQ(offered("odom identify cog --config c", folder), Words{"car.toml"});
  EXPECT_EQ(offered("odom bridge --frame-map c", folder), Words{});
  EXPECT_EQ(offered("odom pose --shm c", folder), Words{"car.toml"});
  EXPECT_THAT(offered("odomd --can \"\"", folder),
              IsSupersetOf(Words{"-", "car.toml", "drive.log"}));
}

TEST(Completions, OfZshAndFishAreSound) {
  // Shells that are installed must accept their files.
  for (const char* line :
       {"command -v zsh >/dev/null || exit 0; zsh -n " ODOMD_COMPLETIONS "/odom.zsh",
        "command -v fish >/dev/null || exit 0; fish -n " ODOMD_COMPLETIONS "/odom.fish"}) {
    must_run(line);
  }
}

// The manual pages
// -------------------------------------------------------------------------------

// A section of a page: from its heading to the next one of the same or a higher level.
std::string part_of(const std::string& page, const std::string& heading) {
  const std::string start = '\n' + heading + '\n';
  const auto begin = page.find(start);
  if (begin == std::string::npos) return "";
  const auto end = std::min(page.find("\n.Ss ", begin + 1), page.find("\n.Sh ", begin + 1));
  return page.substr(begin, end - begin);
}

TEST(ManPages, HaveEveryCommandAndOptionOfTheHelp) {
  const std::string odom = contents(ODOMD_SOURCE_DIR "/man/odom.1");
  const std::string odomd = contents(ODOMD_SOURCE_DIR "/man/odomd.8");
  for (const Command& command : all_commands()) {
    const bool whole = command.name.find(' ') == std::string::npos;
    const std::string& page = program_of(command) == "odom" ? odom : odomd;
    const std::string part = part_of(page, whole ? ".Sh DESCRIPTION" : ".Ss " + command.name);
    EXPECT_NE(part, "") << command.name << ": has no part of its own";
    for (const std::string& option : command.options) {
      if (!option.starts_with("--")) continue;
      if (!whole && option == "--help") continue;  // described once for all commands
      const std::regex item("\n\\.It (Fl . , )?Fl Fl " + option.substr(2) + "[ \n]");
      EXPECT_TRUE(std::regex_search(part, item)) << command.name << ' ' << option;
    }
    // The page has no option that no longer exists.
    static const std::regex any("\\n\\.It (?:Fl . , )?Fl Fl ([-a-z0-9]+)");
    for (std::sregex_iterator at(part.begin(), part.end(), any), end; at != end; ++at)
      EXPECT_THAT(command.options, Contains("--" + (*at)[1].str()))
          << command.name << (whole ? "" : "; write options of a daemon elsewhere");
  }
  static const std::regex heading("\\n\\.Ss (odom [a-z ]+)");
  for (std::sregex_iterator at(odom.begin(), odom.end(), heading), end; at != end; ++at)
    EXPECT_TRUE(std::any_of(all_commands().begin(), all_commands().end(),
                            [&](const Command& command) { return command.name == (*at)[1]; }))
        << (*at)[1];
}

// These pages refer to odom(1) for the options, but name some of them.
TEST(ManPages, OfProgramsBehindCommandsNameOptionsThatExist) {
  static const std::regex option("Fl Fl ([-a-z0-9]+)");
  for (const auto& [page, name] :
       {std::pair<std::string, std::string>{"odom-web.1", "serve"}, {"odom-bridge.1", "bridge"}}) {
    const std::string text = contents(ODOMD_SOURCE_DIR "/man/" + page);
    EXPECT_THAT(text, HasSubstr("\n.Nm odom Cm " + name + " ;\n"));
    const std::set<std::string> options = command_of("odom " + name).options;
    std::sregex_iterator at(text.begin(), text.end(), option);
    EXPECT_NE(at, std::sregex_iterator{}) << page << " names no option";
    for (; at != std::sregex_iterator{}; ++at)
      EXPECT_THAT(options, Contains("--" + (*at)[1].str())) << page;
  }
}

TEST(ManPages, AreSound) {
  const Outcome outcome =
      run_shell("cd " ODOMD_SOURCE_DIR
                "/man && for page in *.[1-9]; do mandoc -T lint -W warning $page; done");
  EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST(CommandLines, RefuseNumbersThatAreNone) {
  for (const std::string number : {"nan", "inf", "-1", "0", "2s"})
    EXPECT_THAT(run_shell("odom plot --out a.svg --for " + number),
                Ends(2, "odom plot: --for: \"" + number +
                            "\" is not a finite number greater than 0; see odom plot --help\n"));
  EXPECT_THAT(run_shell("odom record --wait nan"),
              Ends(2, HasSubstr("--wait: \"nan\" is not a finite number, 0 or greater")));
}

// The answer names the first misspelt word and its correction, and where the help is.
TEST(CommandLines, AnswerWhatIsMisspelt) {
  for_each_row(R"(
odom sim | --scenari lap -> unknown option "--scenari" (did you mean "--scenario"?)
odom sim | --scenario=lap --lpas=3 -> unknown option "--lpas" (did you mean "--laps"?)
odom replay | --ot x --config c -> unknown option "--ot" (did you mean "--out"?)
odom sim | -laps 3 -> unknown option "-laps" (did you mean "--laps"?)
odom watch | --nonsense -> unknown option "--nonsense"
# A command that is unknown has no help.
odom dbc | shwo --help -> no command "shwo" (did you mean "show"?)
odom evaluate | --refrence x --poes y -> unknown option "--refrence" (did you mean "--reference"?)
odom watch | status -> unexpected argument "status"
# Before the option that is missing for it.
odom plot | pose.csv --otu x.png -> unknown option "--otu" (did you mean "--out"?)
odomd | --confg car.toml --cna can0 -> unknown option "--confg" (did you mean "--config"?)
odomd | start -> unexpected argument "start"
odomd | -> --config is required
# Before its command.
odom | --config car.toml replay -> unknown option "--config": options go after the command that has them
odom | --config car.toml -> unknown option "--config": options go after the command that has them
odom camera | --foo send -> unknown option "--foo": options go after the command that has them
odom | evalute --pose x -> no command "evalute" (did you mean "evaluate"?)
odom identify | ltency -> no command "ltency" (did you mean "latency"?)
odom dbc | nonsense -> no command "nonsense"; there are: show, decode
odom dbc | -> no command given; there are: show, decode
# Options of the companion programs.
odom identify fit | --confg car.toml --drvie x -> unknown option "--confg" (did you mean "--config"?)
odom identify track | film.mp4 --mraker x -> unknown option "--mraker"
)",
               [](const std::string& line, const std::string& answer) {
                 const std::string command = line.substr(0, line.find(" |"));
                 const Outcome outcome = run_shell(command + line.substr(command.size() + 2));
                 EXPECT_THAT(outcome,
                             Ends(2, command + ": " + answer + "; see " + command + " --help\n"));
                 EXPECT_EQ(outcome.out, "") << line;
               });
  EXPECT_THAT(run_shell("odom evaluate a b c"),
              Ends(2, "odom evaluate: a: is not a folder; check the path\n"));
}

}  // namespace
}  // namespace odomd::tools::command_lines_test
