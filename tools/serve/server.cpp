#include "tools/serve/server.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "base/file_descriptor.hpp"

namespace odomd::serve {

// Made from the folder page/ by the build.
extern const char* const page_html;
extern const char* const page_css;
extern const char* const page_js;

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::size_t request_threads = 16;
constexpr std::size_t max_recent = 40;  ///< events: two seconds
constexpr std::size_t max_request = 16'384;
constexpr std::size_t max_line = 1'536;  ///< std::regex uses stack for each character
constexpr milliseconds max_request_time{2'000};
constexpr milliseconds max_stall{5'000};
constexpr int send_buffer = 16'384;  ///< of the kernel: about a second of events

/// Limits the bytes and the time of a whole request, where cpp-httplib limits single reads.
class Connection final : public httplib::Stream {
 public:
  explicit Connection(int socket) : socket_(socket) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() override {
    // Closing with bytes unread would make the kernel discard the answer.
    ::shutdown(socket_.get(), SHUT_WR);
    std::array<char, 4096> rest{};
    for (int i = 0; i < 16 && wait(POLLIN, milliseconds{100}); ++i)
      if (::recv(socket_.get(), rest.data(), rest.size(), MSG_DONTWAIT) <= 0) break;
  }

  [[nodiscard]] bool is_readable() const override {
    return wait(POLLIN, std::chrono::ceil<milliseconds>(deadline_ - steady_clock::now()));
  }
  [[nodiscard]] bool is_writable() const override { return wait(POLLOUT, max_stall); }
  ssize_t read(char* to, std::size_t size) override {
    if (left_ == 0 || !is_readable()) return -1;
    const ssize_t got = ::recv(socket_.get(), to, std::min(size, left_), MSG_DONTWAIT);
    if (got > 0) left_ -= static_cast<std::size_t>(got);
    for (ssize_t i = 0; i < got; ++i) line_ = to[i] == '\n' ? 0 : line_ + 1;
    return line_ > max_line ? -1 : got;
  }
  ssize_t write(const char* from, std::size_t size) override {
    return is_writable() ? ::send(socket_.get(), from, size, MSG_DONTWAIT | MSG_NOSIGNAL) : -1;
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}  // not needed
  void get_local_ip_and_port(std::string&, int&) const override {}
  [[nodiscard]] socket_t socket() const override { return socket_.get(); }

 private:
  [[nodiscard]] bool wait(short events, milliseconds limit) const {
    pollfd ready{socket_.get(), events, 0};
    return limit.count() > 0 && ::poll(&ready, 1, static_cast<int>(limit.count())) > 0;
  }

  FileDescriptor socket_;
  steady_clock::time_point deadline_ = steady_clock::now() + max_request_time;
  std::size_t left_ = max_request;
  std::size_t line_ = 0;  // length of the line so far; only heads are read
};

/// The accepted Host headers: an address, localhost, or this machine's name. If the name of another
/// site resolves to this machine, requests of its pages have that name in the header.
std::string own_hosts() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return fmt::format(R"((localhost|[0-9.]+|\[[0-9a-f:.]+\]|{}(\.local)?)(:\d+)?)",
                     std::regex_replace(name.data(), std::regex{"\\."}, "\\."));
}

bool is_token(std::string_view given, const std::string& token) {
  return given.size() == token.size() &&
         CRYPTO_memcmp(given.data(), token.data(), token.size()) == 0;
}

/// The token in the cookie, or in a program's Authorization header.
std::string given_token(const httplib::Request& request) {
  constexpr std::string_view bearer = "Bearer ";
  const std::string authorization = request.get_header_value("Authorization");
  if (authorization.starts_with(bearer)) return authorization.substr(bearer.size());
  constexpr std::string_view name = "; odom_token=";
  const std::string cookies = "; " + request.get_header_value("Cookie");
  const std::size_t at = cookies.find(name);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size();
  return cookies.substr(begin, cookies.find(';', begin) - begin);
}

httplib::Server::HandlerResponse answer(httplib::Response& response, int status,
                                        const std::string& text) {
  response.status = status;
  response.set_content(text + '\n', "text/plain; charset=utf-8");
  return httplib::Server::HandlerResponse::Handled;
}

}  // namespace

Server::Server(Endpoint endpoint)
    : endpoint_(std::move(endpoint)), own_hosts_(own_hosts(), std::regex::icase) {
  new_task_queue = [] { return new httplib::ThreadPool(max_viewers + request_threads); };
  // Without SO_REUSEPORT, which cpp-httplib sets: a second server must not share the port.
  set_socket_options([](socket_t socket) {
    constexpr int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
  });
  set_tcp_nodelay(true);
  set_payload_max_length(1);
  set_default_headers({{"Content-Security-Policy",
                        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src "
                        "'self'; img-src data:; base-uri 'none'; form-action 'none'; "
                        "frame-ancestors 'none'"},
                       {"Cross-Origin-Resource-Policy", "same-origin"},
                       {"X-Content-Type-Options", "nosniff"},
                       {"Referrer-Policy", "no-referrer"},
                       {"Cache-Control", "no-store"}});
  set_pre_routing_handler(
      [this](const auto& request, auto& response) { return guard(request, response); });
  add_routes();
  errno = 0;
  const int asked = endpoint_.port;
  if (asked == 0) endpoint_.port = bind_to_any_port(endpoint_.address);
  if (asked == 0 ? endpoint_.port < 0 : !bind_to_port(endpoint_.address, asked))
    throw std::runtime_error(fmt::format("cannot listen at {} port {}: {}; --listen names another",
                                         endpoint_.address, asked, std::strerror(errno)));
  ::listen(svr_sock_, max_viewers);  // cpp-httplib's backlog is too short for all viewers at once
  thread_ = std::thread{[this] {
    listen_after_bind();
    ended_ = true;
  }};
}

Server::~Server() {
  while (!is_running() && !ended_) std::this_thread::yield();  // before that stop() does nothing
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  published_.notify_all();
  stop();
  thread_.join();
}

void Server::publish(std::string event, bool is_start) {
  {
    const std::lock_guard lock(mutex_);
    if (is_start) start_ = count_;
    ++count_;
    recent_.push_back(std::make_shared<const std::string>(std::move(event)));
    if (recent_.size() > max_recent) recent_.pop_front();
  }
  published_.notify_all();
}

void Server::set_answers(std::string history, std::string metrics) {
  const std::lock_guard lock(mutex_);
  history_ = std::move(history);
  metrics_ = std::move(metrics);
}

// Waits for the event with this number, or takes the oldest that is left; null at the end.
Server::Event Server::wait_for(std::uint64_t& next) {
  std::unique_lock lock(mutex_);
  published_.wait(lock, [&] { return ended_ || next < count_; });
  if (ended_) return nullptr;
  const std::uint64_t oldest = count_ - recent_.size();
  next = std::max(next, oldest);
  return recent_[next++ - oldest];
}

void Server::open_stream(const httplib::Request& request, httplib::Response& response) {
  if (request.method == "HEAD") return;
  if (viewers_.fetch_add(1) >= max_viewers) {
    --viewers_;
    response.set_header("Retry-After", "5");
    answer(response, 503, fmt::format("all {} places for viewers are taken", max_viewers));
    return;
  }
  const std::lock_guard lock(mutex_);
  response.set_content_provider(
      "text/event-stream",
      [this, next = start_](std::size_t, httplib::DataSink& sink) mutable {
        const Event event = wait_for(next);
        return event && sink.write(event->data(), event->size());
      },
      [this](bool) { --viewers_; });
}

void Server::add_routes() {
  using httplib::Request;
  using httplib::Response;
  const auto add = [this](const char* path, const char* type, const char* text) {
    Get(path, [=](const Request&, Response& response) {
      response.set_content(text, std::strlen(text), type);
    });
  };
  add("/", "text/html; charset=utf-8", page_html);
  add("/page.css", "text/css; charset=utf-8", page_css);
  add("/page.js", "text/javascript; charset=utf-8", page_js);
  const auto add_changing = [this](const char* path, const char* type, const std::string& text) {
    Get(path, [=, this, &text](const Request&, Response& response) {
      const std::lock_guard lock(mutex_);
      response.set_content(text, type);
    });
  };
  add_changing("/history", "application/json", history_);
  add_changing("/metrics", "application/openmetrics-text; version=1.0.0; charset=utf-8", metrics_);
  Get("/events",
      [this](const Request& request, Response& response) { open_stream(request, response); });
}

httplib::Server::HandlerResponse Server::guard(const httplib::Request& request,
                                               httplib::Response& response) const {
  if (request.method != "GET" && request.method != "HEAD") {
    response.set_header("Allow", "GET, HEAD");
    return answer(response, 405, "only GET and HEAD");
  }
  const std::string host = request.get_header_value("Host");
  if (request.get_header_value_count("Host") != 1 || host.size() > 255 ||
      !std::regex_match(host, own_hosts_))
    return answer(response, 403, "unknown Host: use the car's address or its host name");
  const auto [begin, end] = request.headers.equal_range("Origin");
  if (std::any_of(begin, end,
                  [&](const auto& origin) { return origin.second != "http://" + host; }))
    return answer(response, 403, "pages of other sites may not read");
  const std::string& token = endpoint_.token;
  if (token.empty()) return HandlerResponse::Unhandled;
  const std::string in_address = request.get_param_value("token");
  if (is_token(in_address, token)) {
    constexpr const char* cookie =
        "odom_token={}; Path=/; HttpOnly; SameSite=Strict; Max-Age=31536000";
    response.set_header("Set-Cookie", fmt::format(cookie, token));
    response.set_redirect("/", 303);
    return HandlerResponse::Handled;
  }
  const std::string given = given_token(request);
  if (is_token(given, token)) return HandlerResponse::Unhandled;
  response.set_header("WWW-Authenticate", "Bearer");
  return answer(response, 401,
                in_address.empty() && given.empty()
                    ? "open this page once with /?token=TOKEN, the token of the car"
                    : "this is not the car's token: it is in the file of --token-file");
}

bool Server::process_and_close_socket(socket_t socket) {
  Connection connection{socket};
  bool closed = false;
  return process_request(connection, true, closed, [](httplib::Request& request) {
    request.ranges.clear();  // many overlapping ranges would make a large answer
  });
}

}  // namespace odomd::serve
