#include "tools/cli/command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

/// A rule that accepts numbers that pass `check`. CLI11's own range checks accept "nan".
template <typename T, typename Check>
Rule number_rule(const Check& check, const std::string& problem, const std::string& shown) {
  const auto problem_of = [=](std::string text) {
    T value{};
    return CLI::detail::lexical_cast(text, value) && std::isfinite(static_cast<double>(value)) &&
                   check(value)
               ? ""
               : tools::quoted(text) + ' ' + problem;
  };
  return [=](CLI::Option& option) { option.check(problem_of, shown); };
}

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw CLI::ValidationError(file, what);
}

Json read_measurements(const std::string& file) {
  const std::string text = read_whole(file);
  const Json json = Json::parse(text, nullptr, false);
  static const std::regex decimal_comma(R"re("([^"]{1,99})"\s{0,9}:\s{0,9}[-+]?\d{1,18},\d)re");
  if (std::smatch match; json.is_discarded() && std::regex_search(text, match, decimal_comma))
    fail(file, match.str(1) + ": write a number with a decimal point: 2.5, not 2,5");
  if (!json.is_object())
    fail(file, "is not a JSON object of measurements, such as {\"total\": 2.985}");
  return json;
}

std::string value_text(const Json& value, const std::string& name, const std::string& file) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return value.dump();
  fail(file, name + " must be a number, a text, or a list of them");
}

/// Sets the options of a command to their values in the file.
void apply_measurements(CLI::App& app, const std::string& file) {
  const Json measurements = read_measurements(file);
  for (const auto& [name, value] : measurements.items()) {
    std::string flag = "--" + name;
    std::ranges::replace(flag, '_', '-');
    CLI::Option* const option = app.get_option_no_throw(flag);
    if (option == nullptr) {
      const auto siblings = app.get_parent()->get_subcommands([](CLI::App*) { return true; });
      if (std::ranges::none_of(siblings, [&](const CLI::App* sibling) {
            return sibling->get_option_no_throw(flag) != nullptr;
          }))
        fail(file, name + " is not the name of an option");
      continue;
    }
    const auto given = [](const CLI::Option* one) { return one->count() > 0; };
    if (given(option) || std::ranges::any_of(option->get_excludes(), given)) continue;
    if (!value.is_array())
      option->add_result(value_text(value, name, file));
    else
      for (const Json& one : value) option->add_result(value_text(one, name, file));
  }
}

}  // namespace

Rule required() {
  return [](CLI::Option& option) { option.required(); };
}

Rule needs(const std::string& other) {
  return [other](CLI::Option& option) { option.needs(other); };
}

Rule excludes(const std::string& other) {
  return [other](CLI::Option& option) { option.excludes(other); };
}

Rule positive() {
  const auto above_0 = [](double value) { return value > 0.0; };
  return number_rule<double>(above_0, "is not a finite number greater than 0", "POSITIVE");
}

Rule not_negative() {
  const auto from_0 = [](double value) { return value >= 0.0; };
  return number_rule<double>(from_0, "is not a finite number, 0 or greater", "NONNEGATIVE");
}

template <typename T>
Rule within(T least, T most, Bounds bounds) {
  const std::string shown =
      fmt::format("{} in [{} - {}]", CLI::detail::type_name<T>(), least, most);
  return number_rule<T>([=](T value) { return value >= least && value <= most; },
                        fmt::format("is not a number from {} to {}", least, most),
                        bounds == Bounds::in_text ? "" : shown);
}
template Rule within(int, int, Bounds);
template Rule within(double, double, Bounds);

Rule checked(const std::function<std::string(const std::string&)>& problem) {
  return [problem](CLI::Option& option) { option.check(problem); };
}

Rule values(int count) {
  return [count](CLI::Option& option) { option.expected(count); };
}

Rule delimiter(char between) {
  return [between](CLI::Option& option) { option.delimiter(between); };
}

Rule value_if_none(const std::string& value) {
  return [value](CLI::Option& option) { option.expected(0, 1)->default_str(value); };
}

Rule one_each() {
  return [](CLI::Option& option) { option.allow_extra_args(false); };
}

Rule repeatable() {
  return [](CLI::Option& option) { option.expected(1)->take_all()->allow_extra_args(false); };
}

Command Command::group(const std::string& heading) const {
  Command same = *this;
  same.heading_ = heading;
  return same;
}

void Command::complete(CLI::Option& option, const Rules& rules) const {
  if (!heading_.empty()) option.group(heading_);
  for (const Rule& rule : rules) rule(option);
}

void Command::program(const std::string& name, const std::string& version) const {
  app_->name(name);
  app_->set_version_flag("--version", version, "Print the version and exit");
  app_->set_help_flag("-h,--help", "Print this help and exit");
}

void Command::description(const std::string& sentence) const {
  app_->description(sentence);
}

void Command::footer(const std::string& text) const {
  app_->footer(text);
}

Command Command::add_subcommand(const std::string& name, const std::string& sentence) const {
  return Command(*app_->add_subcommand(name, sentence));
}

void Command::require_subcommand() const {
  app_->require_subcommand(1);
}

bool Command::has_called_subcommand() const {
  return !app_->get_subcommands().empty();
}

template <OptionValue T>
void Command::add(const std::string& name, const std::string& type, T& value,
                  const std::string& help, const Rules& rules) const {
  complete(*app_->add_option(name, value, help)->type_name(type), rules);
}
using Text = const std::string&;
template void Command::add(Text, Text, std::string&, Text, const Rules&) const;
template void Command::add(Text, Text, std::filesystem::path&, Text, const Rules&) const;
template void Command::add(Text, Text, int&, Text, const Rules&) const;
template void Command::add(Text, Text, std::uint64_t&, Text, const Rules&) const;
template void Command::add(Text, Text, double&, Text, const Rules&) const;
template void Command::add(Text, Text, std::optional<int>&, Text, const Rules&) const;
template void Command::add(Text, Text, std::optional<double>&, Text, const Rules&) const;
template void Command::add(Text, Text, std::vector<std::string>&, Text, const Rules&) const;
template void Command::add(Text, Text, std::vector<double>&, Text, const Rules&) const;

void Command::add_flag(const std::string& name, const std::function<void()>& set,
                       const std::string& help, const Rules& rules) const {
  complete(*app_->add_flag_callback(name, set, help), rules);
}

void Command::add_choice(const std::string& name, const std::vector<std::string>& names,
                         const std::function<void(std::size_t)>& choose, const std::string& help,
                         const Rules& rules) const {
  const std::string type = fmt::format("{}", fmt::join(names, "|"));
  const auto choose_named = [=](const std::string& given) {
    const auto found = std::ranges::find(names, given);
    if (found == names.end())
      throw CLI::ValidationError(name, tools::quoted(given) + " is none of " + type);
    choose(static_cast<std::size_t>(found - names.begin()));
  };
  complete(*app_->add_option_function<std::string>(name, choose_named, help)->type_name(type),
           rules);
}

void Command::add_measurements(const std::string& name, const std::string& type,
                               const std::string& help) const {
  const auto apply = [app = app_](const std::string& file) { apply_measurements(*app, file); };
  complete(*app_->add_option_function<std::string>(name, apply, help)->type_name(type), {});
}

void Command::add_rules(const std::string& name, const Rules& rules) const {
  complete(*app_->get_option(name), rules);
}

void Command::callback(const std::function<void()>& action) const {
  app_->callback(action);
}

void require(const std::string& what) {
  throw CLI::RequiredError(what);
}

void add_segment_option(Command command, std::string& name, SegmentElse otherwise,
                        const Rules& rules) {
  command.add(
      "--shm", "NAME", name,
      fmt::format(
          "Shared memory segment: a name (/odomd) or a path; default: {}$ODOM_SHM; otherwise the "
          "first of /odomd and /run/odomd/INTERFACE/pose of the service whose daemon is running",
          otherwise == SegmentElse::of_socket
              ? "with --socket, the segment of that daemon; otherwise "
              : ""),
      rules);
}

void add_socket_option(Command command, std::string& path, const std::string& purpose,
                       const Rules& rules) {
  std::string capital = purpose;
  capital.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(purpose.front())));
  command.add(
      "--socket", "PATH", path,
      fmt::format(
          "{} socket of the daemon; default: $XDG_RUNTIME_DIR/odomd/{}.sock, if it exists; "
          "otherwise /run/odomd/INTERFACE/{}.sock of the service; otherwise /run/odomd/{}.sock",
          capital, purpose, purpose, purpose),
      rules);
}

void add_wait_option(Command command, double& seconds) {
  command.add("--wait", "S", seconds, "Wait this long for a daemon to appear [s]; default: 0",
              {not_negative()});
}

}  // namespace odomd::tools
