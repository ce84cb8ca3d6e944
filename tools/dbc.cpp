// odom dbc: looks into CAN databases and decodes logs by them.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "tools/commands.hpp"
#include "tools/dbc_commands.hpp"

namespace odomd::tools {

std::string json_text(const nlohmann::ordered_json& value, int indent) {
  return value.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string shortest(double value) {
  std::string text = json_text(value);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  if (text == "null") return fmt::format("{}", value);  // JSON has no word for inf and nan
  return text;
}

std::string hexadecimal(std::uint32_t id, can::IdFormat format) {
  return format == can::IdFormat::extended ? fmt::format("{:08X}", id) : fmt::format("{:03X}", id);
}

void add_dbc(CLI::App& odom) {
  struct Options {
    std::string file;
    std::vector<std::string> databases;
    std::string log;
    bool json = false;
    bool all = false;
  };
  const auto options = std::make_shared<Options>();
  const auto form = [options] { return options->json ? OutputForm::json : OutputForm::readable; };

  CLI::App* dbc = odom.add_subcommand("dbc", "Look into CAN databases and decode logs by them");
  dbc->require_subcommand(1);

  CLI::App* show_command = dbc->add_subcommand("show", "Print the messages and signals of a DBC");
  show_command->add_option("FILE", options->file, "The database")->required();
  show_command->add_flag("--json", options->json, "One JSON object instead of tables");
  show_command->footer("Example: odom dbc show car.dbc");
  show_command->callback([options, form] { show_dbc(options->file, form()); });

  CLI::App* decode_command =
      dbc->add_subcommand("decode", "Decode a candump log, one line a frame");
  decode_command
      ->add_option("--dbc", options->databases,
                   "The database; of several the first that has an identifier decodes it")
      ->required()
      ->allow_extra_args(false);
  decode_command->add_option("LOG", options->log, "A log of candump -L, or - for standard input")
      ->required();
  decode_command->add_flag("--json", options->json, "One JSON object a line");
  decode_command->add_flag("--all", options->all, "Also frames that no database knows");
  decode_command->footer(
      "Examples: odom dbc decode --dbc car.dbc --json drive.log\n"
      "          candump -L can0 | odom dbc decode --dbc car.dbc -");
  decode_command->callback([options, form] {
    decode_log(options->databases, options->log, form(),
               options->all ? Frames::all : Frames::known);
  });
}

}  // namespace odomd::tools
