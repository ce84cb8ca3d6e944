#include "tools/cli/command_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <ranges>
#include <stdexcept>
#include <string_view>

#include <CLI/CLI.hpp>

#include "daemon/core/usage.hpp"
#include "shm_api/cut_short.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {
namespace {

int report(const std::string& command, std::string_view text, int status) {
  std::cout.flush();
  say(command + ": " + std::string(text));
  return status;
}

// The command line of this process.
std::vector<std::string> given_words() {
  std::ifstream file{"/proc/self/cmdline", std::ios::binary};
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

// The word, quoted for a shell if necessary.
std::string shell_word(const std::string& word) {
  const auto is_plain = [](char one) {
    return std::isalnum(static_cast<unsigned char>(one)) != 0 ||
           std::string_view{"_./:=,+@%-"}.find(one) != std::string_view::npos;
  };
  if (!word.empty() && std::ranges::all_of(word, is_plain)) return word;
  std::string quoted = "'";
  for (const char one : word) quoted += one == '\'' ? std::string{"'\\''"} : std::string{one};
  return quoted + '\'';
}

}  // namespace

CommandLine::CommandLine() : app_(std::make_unique<CLI::App>()) {}

CommandLine::~CommandLine() = default;

int CommandLine::run(int argc, const char* const* argv) noexcept {
  CLI::App& odom = *app_;
  int status = exit_done;
  try {
    try {
      daemon::refuse_empty_values(odom);
      odom.parse(argc, argv);
    } catch (const Ended& ended) {
      status = ended.status();
    } catch (const CLI::ParseError& error) {
      // "odom nonsense --help" does not ask for the help of odom.
      const CLI::App* called = &odom;
      while (!called->get_subcommands().empty()) called = called->get_subcommands().front();
      const auto any = [](const CLI::App*) { return true; };
      const bool of_no_command =
          !called->get_subcommands(any).empty() && !called->remaining().empty();
      if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success) && !of_no_command) {
        odom.exit(error);  // help or version, to standard output
      } else {
        const daemon::Mistake mistake = daemon::mistake_in(odom, error);
        return report(mistake.command, mistake.what + "; see " + mistake.command + " --help",
                      exit_usage);
      }
    }
    if (!std::cout.flush())
      return report(daemon::called_name(odom), "standard output: " + why_unwritten(std::cout),
                    exit_failed);
    return status;
  } catch (const std::invalid_argument& error) {
    return report(daemon::called_name(odom), error.what(), exit_usage);
  } catch (const std::exception& error) {
    return report(daemon::called_name(odom), error.what(), exit_failed);
  }
}

std::string given_command() {
  std::string text = "odom";
  for (const std::string& word : given_words() | std::views::drop(1))
    text += ' ' + shell_word(word);
  return text;
}

int run_program(const std::function<void(Command)>& describe, int argc, const char* const* argv) {
  static_cast<void>(std::signal(SIGPIPE, SIG_DFL));
  shm::end_where_a_segment_is_cut_short("odom");
  const StandardStreams streams;
  CommandLine line;
  describe(line.command());
  return line.run(argc, argv);
}

void become(const std::string& program, std::vector<std::string> arguments,
            const std::string& where_missing) {
  const auto path = std::filesystem::read_symlink("/proc/self/exe").parent_path() / program;
  arguments.insert(arguments.begin(), path.string());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  ::execv(path.c_str(), argv.data());
  if (errno == ENOENT) throw std::runtime_error(where_missing);
  throw std::runtime_error(path.string() + ": " + std::strerror(errno));
}

void hand_over(const Command& command, const std::string& program,
               const std::string& where_missing) {
  std::vector<std::string> words = given_words();
  for (const CLI::App* app = &command.app(); app != nullptr; app = app->get_parent()) {
    if (words.empty()) throw std::runtime_error("/proc/self/cmdline cannot be read");
    words.erase(words.begin());
  }
  become(program, std::move(words), where_missing);
}

}  // namespace odomd::tools
