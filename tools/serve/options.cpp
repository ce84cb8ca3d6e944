#include "tools/serve/options.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <fmt/format.h>
#include <cerrno>
#include <cstring>
#include <regex>
#include <stdexcept>

#include "base/file_descriptor.hpp"
#include "base/printable.hpp"

namespace odomd::serve {
namespace {

std::string read_token(const std::filesystem::path& file) {
  const auto fail = [&file](const std::string& problem) {
    throw std::invalid_argument("--token-file " + file.string() + ": " + problem);
  };
  const FileDescriptor opened{::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct stat status {};
  if (!opened || ::fstat(opened.get(), &status) != 0) fail(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) fail("not a file");
  const mode_t mode = status.st_mode & 07777U;
  if ((mode & ~mode_t{0640}) != 0)
    fail(fmt::format("mode {:04o} is too open; run: chmod 0640 {}", mode, file.string()));
  std::string token(256, '\0');
  const ssize_t size = ::read(opened.get(), token.data(), token.size());
  token.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  if (token.ends_with('\n')) token.pop_back();
  // Characters that need no escaping in an address and in a cookie.
  if (!std::regex_match(token, std::regex{"[A-Za-z0-9._~-]{16,128}"}))
    fail("not a token: 16 to 128 letters, digits, - . _ ~; make one: openssl rand -hex 16");
  return token;
}

}  // namespace

void describe_serve(tools::Command command, Options& options) {
  command.description("Show the running daemon in a browser: a page, and metrics for Prometheus");
  tools::add_segment_option(command, options.shm, tools::SegmentElse::of_socket);
  tools::add_socket_option(command, options.socket, "status");
  command.add("--listen", "ADDR[:PORT]", options.listen,
              "Address to listen on; other machines need --token-file; default: 127.0.0.1:9880");
  command.add("--token-file", "FILE", options.token_file,
              "File with the token that a browser must present once; mode 0640 or stricter");
  command.footer(
      "Examples:\n"
      "  odom serve                        # http://127.0.0.1:9880/\n"
      "  (umask 077; openssl rand -hex 16 > token)\n"
      "  odom serve --listen 0.0.0.0 --token-file token\n"
      "  curl http://127.0.0.1:9880/metrics\n"
      "On the phone, open http://CAR:9880/?token=TOKEN once; a cookie then keeps the token.\n"
      "odom serve waits for the daemon, and again when it restarts. INT and TERM end it. See "
      "docs/web.md.");
}

Endpoint endpoint_of(const Options& options) {
  static const std::regex form{R"(\[([0-9a-fA-F:.]+)\](?::(\d{1,5}))?|([^:]+)(?::(\d{1,5}))?)"};
  std::smatch part;
  const bool matches = std::regex_match(options.listen, part, form);
  Endpoint endpoint{part[1].matched ? part[1] : part[3], 9880, {}};
  if (endpoint.address == "localhost") endpoint.address = "127.0.0.1";
  for (const std::size_t i : {2U, 4U})
    if (part[i].matched) endpoint.port = std::stoi(part[i]);
  in_addr four{};
  in6_addr six{};
  const bool is_four = ::inet_pton(AF_INET, endpoint.address.c_str(), &four) == 1;
  if (!matches || endpoint.port > 65'535 ||
      (!is_four && ::inet_pton(AF_INET6, endpoint.address.c_str(), &six) != 1))
    throw std::invalid_argument(
        "--listen " + odomd::quoted(options.listen) +
        ": not ADDR[:PORT]; an address of this machine, such as 127.0.0.1:9880, 0.0.0.0 or [::]");
  if (!options.token_file.empty()) endpoint.token = read_token(options.token_file);
  const bool is_loopback =
      is_four ? (ntohl(four.s_addr) >> 24U) == 127 : IN6_IS_ADDR_LOOPBACK(&six);
  if (endpoint.token.empty() && !is_loopback)
    throw std::invalid_argument(
        "--listen " + options.listen +
        ": other machines reach this address, so it needs a --token-file; make one: (umask 077; "
        "openssl rand -hex 16 > token)");
  return endpoint;
}

}  // namespace odomd::serve
