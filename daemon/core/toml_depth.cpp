#include "daemon/core/toml_depth.hpp"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

#include "daemon/core/config_error.hpp"

namespace odomd::daemon {
namespace {

/// The position after the quoted string that opens at `at`; a single-line string ends with the
/// line.
std::size_t past_quotes(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? R"(""")" : "'''";
  const bool several_lines = text.substr(at, 3) == three;
  for (at += several_lines ? 3 : 1; at < text.size(); ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (!several_lines) {
      if (text[at] == quote) return at + 1;
      if (text[at] == '\n') return at;
    } else if (text.substr(at, 3) == three) {
      // Up to two quotes may come before the closing three.
      const std::size_t end = std::min(text.find_first_not_of(quote, at), text.size());
      return std::min(end, at + 5);
    }
  }
  return text.size();
}

class Scan {
 public:
  Scan(std::string_view text, const std::filesystem::path& file) : text_(text), file_(file) {}

  void run() {
    std::size_t at = 0;
    while (at < text_.size()) {
      const char c = text_[at];
      if (c == '"' || c == '\'') {
        const std::size_t past = past_quotes(text_, at);
        line_ += std::count(text_.begin() + static_cast<std::ptrdiff_t>(at),
                            text_.begin() + static_cast<std::ptrdiff_t>(past), '\n');
        at = past;
      } else if (c == '#') {
        at = std::min(text_.find('\n', at), text_.size());
      } else {
        take(c);
        ++at;
      }
    }
  }

 private:
  void take(char c) {
    switch (c) {
      case '.':
        if (++dots_ >= deepest_key)
          fail(fmt::format("a key of more than {} parts; write the tables that it means",
                           deepest_key));
        return;
      case '[':
      case '{':
        if (++open_ > deepest_brackets)
          fail(fmt::format("more than {} brackets are open; close those before", deepest_brackets));
        break;
      case ']':
      case '}':
        open_ = std::max(0, open_ - 1);
        break;
      case '\n':
        ++line_;
        break;
      case '=':
      case ',':
        break;
      default:
        return;
    }
    dots_ = 0;
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw ConfigError(fmt::format("{}:{}: {}", file_.string(), line_, what));
  }

  std::string_view text_;
  const std::filesystem::path& file_;
  std::ptrdiff_t line_ = 1;
  int dots_ = 0;  // of the current key or number
  int open_ = 0;
};

}  // namespace

void check_depth(std::string_view text, const std::filesystem::path& file) {
  Scan(text, file).run();
}

}  // namespace odomd::daemon
