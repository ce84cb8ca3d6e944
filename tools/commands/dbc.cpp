// odom dbc: shows CAN databases and decodes logs with them.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "tools/commands/commands.hpp"
#include "tools/commands/dbc_commands.hpp"

namespace odomd::tools {

std::string hexadecimal(std::uint32_t id, can::IdFormat format) {
  return format == can::IdFormat::extended ? fmt::format("{:08X}", id) : fmt::format("{:03X}", id);
}

void add_dbc(Command odom) {
  struct Options {
    std::string file;
    std::vector<std::string> databases;
    std::string log;
    bool json = false;
    bool all = false;
  };
  const auto options = std::make_shared<Options>();
  const auto form = [options] { return options->json ? OutputForm::json : OutputForm::readable; };

  Command dbc = odom.add_subcommand("dbc", "Show CAN databases and decode logs with them");
  dbc.require_subcommand();
  dbc.footer(
      "Examples:\n"
      "  odom dbc show car.dbc\n"
      "  odom dbc decode --dbc car.dbc drive.log\n"
      "odom dbc show --help and odom dbc decode --help have more.");

  Command show_command = dbc.add_subcommand("show", "Print the messages and signals of a DBC");
  show_command.add("DBC", "", options->file, "Database (DBC)").required();
  show_command.add_flag("--json", options->json, "Print the database as JSON");
  show_command.footer(
      "Examples:\n"
      "  odom dbc show car.dbc\n"
      "  odom dbc show --json car.dbc | jq '.messages[].name'");
  show_command.callback([options, form] { show_dbc(options->file, form()); });

  Command decode_command = dbc.add_subcommand("decode", "Decode a candump log, one line per frame");
  decode_command
      .add("--dbc", "DBC", options->databases,
           "Database (DBC); repeatable: the first that contains the identifier is used")
      .required()
      .one_each();
  decode_command.add("LOG", "", options->log, "Log of candump -L, or - for standard input")
      .required();
  decode_command.add_flag("--json", options->json, "Print each frame as JSON, one per line");
  decode_command.add_flag("--all", options->all, "Also print frames that are in no database");
  decode_command.footer(
      "Examples:\n"
      "  odom dbc decode --dbc car.dbc drive.log\n"
      "  odom dbc decode --dbc powertrain.dbc --dbc chassis.dbc --json drive.log\n"
      "  candump -L can0 | odom dbc decode --dbc car.dbc -");
  decode_command.callback([options, form] {
    decode_log(options->databases, options->log, form(),
               options->all ? Frames::all : Frames::known);
  });
}

}  // namespace odomd::tools
