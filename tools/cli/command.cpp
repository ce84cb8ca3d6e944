#include "tools/cli/command.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

// CLI11's own checks of a range take "nan".
template <typename T, typename Check>
bool is_number(std::string text, const Check& check) {
  T value{};
  return CLI::detail::lexical_cast(text, value) && std::isfinite(static_cast<double>(value)) &&
         check(value);
}

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw CLI::ValidationError(file, what);
}

Json read_measurements(const std::string& file) {
  std::ifstream input = open_input(file);
  const std::string text{std::istreambuf_iterator<char>(input), {}};
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

/// Gives the options of a command what the file has for them.
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

Option Option::required() const {
  option_->required();
  return *this;
}

Option Option::needs(Option other) const {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(Option other) const {
  option_->excludes(other.option_);
  return *this;
}

Option Option::excludes(const std::string& other) const {
  option_->excludes(other);
  return *this;
}

Option Option::positive() const {
  option_->check(
      [](const std::string& text) {
        return is_number<double>(text, [](double value) { return value > 0.0; })
                   ? ""
                   : tools::quoted(text) + " is not a finite number greater than 0";
      },
      "POSITIVE");
  return *this;
}

Option Option::not_negative() const {
  option_->check(
      [](const std::string& text) {
        return is_number<double>(text, [](double value) { return value >= 0.0; })
                   ? ""
                   : tools::quoted(text) + " is not a finite number, 0 or greater";
      },
      "NONNEGATIVE");
  return *this;
}

template <typename T>
Option Option::within(T least, T most, Bounds bounds) const {
  option_->check(
      [least, most](const std::string& text) {
        return is_number<T>(text, [=](T value) { return value >= least && value <= most; })
                   ? ""
                   : fmt::format("{} is not a number from {} to {}", tools::quoted(text), least,
                                 most);
      },
      bounds == Bounds::in_text
          ? ""
          : fmt::format("{} in [{} - {}]", CLI::detail::type_name<T>(), least, most));
  return *this;
}
template Option Option::within(int, int, Bounds) const;
template Option Option::within(double, double, Bounds) const;

Option Option::check(const std::function<std::string(const std::string&)>& problem) const {
  option_->check(problem);
  return *this;
}

Option Option::values(int count) const {
  option_->expected(count);
  return *this;
}

Option Option::delimiter(char between) const {
  option_->delimiter(between);
  return *this;
}

Option Option::value_if_none(const std::string& value) const {
  option_->expected(0, 1)->default_str(value);
  return *this;
}

Option Option::one_each() const {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::repeatable() const {
  option_->expected(1)->take_all()->allow_extra_args(false);
  return *this;
}

bool Option::is_given() const {
  return option_->count() > 0;
}

Command Command::group(const std::string& heading) const {
  Command same = *this;
  same.heading_ = heading;
  return same;
}

Option Command::grouped(CLI::Option& option) const {
  if (!heading_.empty()) option.group(heading_);
  return Option(option);
}

Command Command::rename(const std::string& name) const {
  app_->name(name);
  return *this;
}

Command Command::description(const std::string& sentence) const {
  app_->description(sentence);
  return *this;
}

Command Command::footer(const std::string& text) const {
  app_->footer(text);
  return *this;
}

Command Command::help_flag() const {
  app_->set_help_flag("-h,--help", "Print this help and exit");
  return *this;
}

Command Command::version_flag(const std::string& version) const {
  app_->set_version_flag("--version", version, "Print the version and exit");
  return *this;
}

Command Command::add_subcommand(const std::string& name, const std::string& sentence) const {
  return Command(*app_->add_subcommand(name, sentence));
}

Command Command::require_subcommand() const {
  app_->require_subcommand(1);
  return *this;
}

bool Command::has_called_subcommand() const {
  return !app_->get_subcommands().empty();
}

template <OptionValue T>
Option Command::add(const std::string& name, const std::string& type, T& value,
                    const std::string& help) const {
  return grouped(*app_->add_option(name, value, help)->type_name(type));
}
using Text = const std::string&;
template Option Command::add(Text, Text, std::string&, Text) const;
template Option Command::add(Text, Text, std::filesystem::path&, Text) const;
template Option Command::add(Text, Text, int&, Text) const;
template Option Command::add(Text, Text, std::uint64_t&, Text) const;
template Option Command::add(Text, Text, double&, Text) const;
template Option Command::add(Text, Text, std::optional<int>&, Text) const;
template Option Command::add(Text, Text, std::optional<double>&, Text) const;
template Option Command::add(Text, Text, std::vector<std::string>&, Text) const;
template Option Command::add(Text, Text, std::vector<double>&, Text) const;

Option Command::add_flag(const std::string& name, bool& value, const std::string& help) const {
  return grouped(*app_->add_flag(name, value, help));
}

Option Command::add_choice(const std::string& name, const std::vector<std::string>& choices,
                           const std::function<void(std::size_t)>& chosen,
                           const std::string& help) const {
  std::string names;
  for (const std::string& choice : choices) names += (names.empty() ? "" : "|") + choice;
  const auto choose = [name, choices, chosen, names](const std::string& given) {
    const auto found = std::find(choices.begin(), choices.end(), given);
    if (found == choices.end())
      throw CLI::ValidationError(name, tools::quoted(given) + " is none of " + names);
    chosen(static_cast<std::size_t>(found - choices.begin()));
  };
  return grouped(*app_->add_option_function<std::string>(name, choose, help)->type_name(names));
}

Option Command::add_measurements(const std::string& name, const std::string& type,
                                 const std::string& help) const {
  const auto apply = [app = app_](const std::string& file) { apply_measurements(*app, file); };
  return grouped(*app_->add_option_function<std::string>(name, apply, help)->type_name(type));
}

std::vector<Option> Command::options() const {
  std::vector<Option> options;
  for (CLI::Option* option : app_->get_options())
    if (option != app_->get_help_ptr()) options.emplace_back(*option);
  return options;
}

std::vector<Command> Command::subcommands() const {
  std::vector<Command> commands;
  for (CLI::App* command : app_->get_subcommands([](CLI::App*) { return true; }))
    commands.emplace_back(*command);
  return commands;
}

std::string Command::name() const {
  return app_->get_name();
}

std::string Command::help(const std::string& name) const {
  // Not app_->help(): that describes the command that was called, not this one.
  return app_->get_formatter()->make_help(app_, name, CLI::AppFormatMode::Normal);
}

std::vector<std::string> Command::given() const {
  std::vector<std::string> result;
  for (const CLI::Option* option : app_->get_options()) {
    if (option->count() == 0) continue;
    const std::string name = option->get_name();
    if (!option->nonpositional()) {
      result.insert(result.end(), option->results().begin(), option->results().end());
    } else if (option->get_items_expected_max() == 0) {
      result.push_back(name);
    } else if (option->get_items_expected_max() == 2 || option->get_items_expected_max() == 3) {
      result.push_back(name);
      result.insert(result.end(), option->results().begin(), option->results().end());
    } else {
      for (const std::string& value : option->results()) {
        result.push_back(name);
        result.back() += "=" + value;
      }
    }
  }
  return result;
}

void Command::callback(const std::function<void()>& action) const {
  app_->callback(action);
}

void require(const std::string& what) {
  throw CLI::RequiredError(what);
}

}  // namespace odomd::tools
