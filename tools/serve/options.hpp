// The command line of odom serve, for `odom`, which executes odom-web, and for odom-web itself.
#pragma once

#include <filesystem>
#include <string>

#include "tools/cli/command.hpp"

namespace odomd::serve {

struct Options {
  std::string shm;     ///< empty: that of the daemon at `socket`, or the library's defaults
  std::string socket;  ///< empty: the default one
  std::string listen = "127.0.0.1";
  std::filesystem::path token_file;  ///< empty: none
};

void describe_serve(tools::Command command, Options& options);

struct Endpoint {
  std::string address;  ///< IPv4 or IPv6
  int port = 0;         ///< 0: any free one
  std::string token;    ///< empty: none, which only loopback addresses allow
};

/// Throws std::invalid_argument for an address or a token file that is not usable.
[[nodiscard]] Endpoint endpoint_of(const Options& options);

}  // namespace odomd::serve
