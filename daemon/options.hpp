// The command line of odomd.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "daemon/core/config.hpp"
#include "daemon/housekeeping/housekeeping.hpp"

namespace odomd::daemon {

/// The command line; values that it does not give come from the configuration.
struct Options {
  std::filesystem::path config;
  std::vector<std::string> sources;
  std::string model;
  std::string initial;
  std::string shm;
  std::string camera_socket;
  std::string status_socket;
  std::string runtime_directory;
  std::string readers;
  std::string camera_senders;
  std::string log_level;
  bool check = false;
  bool exit_at_end = false;
};

/// Describes the whole command line to CLI11.
void add_options(CLI::App& app, Options& options);

/// Reads the configuration and applies the command line to it. Throws std::invalid_argument.
[[nodiscard]] Config configure(const Options& options);

/// Throws std::invalid_argument, naming the key or option, when a group for files does not exist on
/// this machine.
void require_groups(const Options& options, const Config& config);

}  // namespace odomd::daemon
