// odom serve as seen by a browser, an unauthorised client and a broken client.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "tests/tools/child.hpp"
#include "tests/tools/live/own_daemon.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::serve_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::string_view token = "0123456789abcdef-secret";

const char* const status_text = R"({"version": "0.1.0", "instance": "1", "uptime_s": 5.5,
  "mode": "tracking", "conditions": ["sensor_fault", "restarted"],
  "pose": {"vx": 1.5, "reset_count": 2, "sigma_x": null},
  "beat": {"ticks": 1000, "missed": 1, "overruns": 0, "wakeup_us": {"p50": 12.5, "max": 900.0}},
  "can": [{"name": "can\"0\\\n", "link": "up", "received": 7, "lost": 0}],
  "sources": [{"name": "camera", "configured": true, "healthy": false, "flag": "frozen", "age_s": 1.5,
    "verdicts": {"fused": 3, "gated": 1}, "innovations": {"mean_nis": 2.5, "dimension": 3}},
    {"name": "motor", "configured": false, "healthy": false, "verdicts": {}}]})";

class Client {
 public:
  explicit Client(int port, int receive_buffer = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0)
      ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    const timeval limit{10, 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  void send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t sent = ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;
      text.remove_prefix(static_cast<std::size_t>(sent));
    }
  }
  /// Reads until the server closes, or has sent `until`.
  std::string& receive(std::string_view until = "\xff") {
    std::array<char, 65'536> piece{};
    const auto end = steady_clock::now() + milliseconds{20'000};
    while (received_.find(until) == std::string::npos && steady_clock::now() < end) {
      const ssize_t size = ::recv(socket_.get(), piece.data(), piece.size(), 0);
      if (size <= 0) break;
      received_.append(piece.data(), static_cast<std::size_t>(size));
    }
    return received_;
  }
  void end() const { ::shutdown(socket_.get(), SHUT_WR); }
  const std::string& receive_what_came() {
    std::array<char, 65'536> piece{};
    ssize_t size = 0;
    while ((size = ::recv(socket_.get(), piece.data(), piece.size(), MSG_DONTWAIT)) > 0)
      received_.append(piece.data(), static_cast<std::size_t>(size));
    return received_;
  }

 private:
  FileDescriptor socket_;
  std::string received_;
};

class Serve : public ::testing::Test {
 protected:
  void start(std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.begin(), {"serve", "--listen", "127.0.0.1:0", "--shm", segment(),
                                         "--socket", scratch_.path("status.sock").string()});
    server_ = std::make_unique<Child>(scratch_, "odom", arguments);
    std::smatch match;
    std::string errors;
    ASSERT_TRUE(eventually([&] {
      errors = server_->errors();
      return std::regex_search(errors, match, std::regex{"http://127.0.0.1:(\\d+)/"});
    })) << errors;
    port_ = std::stoi(match[1]);
  }
  void start_with_token() {
    const auto file = scratch_.write("token", std::string{token} + '\n');
    std::filesystem::permissions(file, std::filesystem::perms{0640});
    start({"--token-file", file.string()});
  }
  [[nodiscard]] std::string segment() const { return scratch_.path("pose").string(); }
  [[nodiscard]] std::string answer_to(const std::string& request) const {
    Client client{port_};
    client.send(request);
    return client.receive();
  }
  [[nodiscard]] std::string get(const std::string& path, const std::string& headers = "") const {
    return answer_to("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n");
  }
  [[nodiscard]] std::string stream_until(const std::string& part) const {
    Client client{port_};
    client.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return client.receive(part);
  }
  /// Contents of /proc/PID/NAME of the server.
  [[nodiscard]] std::string proc(const std::string& name) const {
    return contents("/proc/" + std::to_string(server_->pid()) + '/' + name);
  }
  [[nodiscard]] long resident_kb() const {
    const std::string status = proc("status");
    return std::stol(status.substr(status.find("VmRSS:") + 6));
  }

  Scratch scratch_;
  std::unique_ptr<Child> server_;
  int port_ = 0;
};

TEST_F(Serve, AnswersItsOwnPagesOnly) {
  start();
  const struct {
    const char* request;
    const char* status;
  } cases[] = {
      {"GET / HTTP/1.1\r\nHost: localhost:9880\r\n\r\n", "200"},
      {"HEAD /events HTTP/1.1\r\nHost: [::1]:9880\r\n\r\n", "200"},
      {"GET /page.js HTTP/1.1\r\nHost: 192.168.1.7\r\n\r\n", "200"},
      {"GET / HTTP/1.1\r\nHost: LOCALHOST\r\nOrigin: http://LOCALHOST\r\n\r\n", "200"},
      {"GET /secret HTTP/1.1\r\nHost: localhost\r\n\r\n", "404"},
      {"GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", "404"},
      // a foreign name that resolves to this machine
      {"GET / HTTP/1.1\r\nHost: rebound.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: 127.0.0.1.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost\r\nHost: rebound.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\n\r\n", "403"},
      // a page of another site or port
      {"GET /events HTTP/1.1\r\nHost: localhost\r\nOrigin: http://other.example\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost:1\r\nOrigin: http://localhost:2\r\n\r\n", "403"},
      {"GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: null\r\n\r\n", "403"},
      {"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc", "405"},
      {"DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n", "405"},
      {"OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n", "405"},
      {"nonsense\r\n\r\n", "400"}};
  for (const auto& [request, status] : cases)
    EXPECT_THAT(answer_to(request), StartsWith(std::string{"HTTP/1.1 "} + status)) << request;
  const std::string page = get("/");
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'"));
  EXPECT_THAT(page, HasSubstr("<title>odomd</title>"));
  EXPECT_EQ(server_->terminate().status, 0);
}

TEST_F(Serve, NeedsTheToken) {
  start_with_token();
  const std::string right{token};
  std::string wrong = right;
  wrong.back() = '!';
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(get("/metrics"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(get("/events"), StartsWith("HTTP/1.1 401"));
  for (const std::string& given : {wrong, right + "x", std::string{"0"}, std::string{}})
    for (const std::string& answer :
         {get("/?token=" + given), get("/", "Cookie: odom_token=" + given + "\r\n"),
          get("/", "Authorization: Bearer " + given + "\r\n")})
      EXPECT_THAT(answer, StartsWith("HTTP/1.1 401")) << given;
  EXPECT_THAT(get("/"), HasSubstr("open this page once with"));
  EXPECT_THAT(get("/?token=" + wrong), HasSubstr("this is not the car's token"));
  EXPECT_THAT(get("/metrics", "Authorization: Bearer " + wrong + "\r\n"),
              HasSubstr("this is not the car's token"));
  const std::string first = get("/?token=" + right);
  EXPECT_THAT(first, AllOf(StartsWith("HTTP/1.1 303"), HasSubstr("Location: /\r\n"),
                           HasSubstr("Set-Cookie: odom_token=" + right +
                                     "; Path=/; HttpOnly; SameSite=Strict")));
  const std::string cookie = "Cookie: theme=dark; odom_token=" + right + "; a=b\r\n";
  EXPECT_THAT(get("/", cookie), StartsWith("HTTP/1.1 200"));
  // The token is removed from the address even if the client has the cookie.
  EXPECT_THAT(get("/?token=" + right, cookie), StartsWith("HTTP/1.1 303"));
  EXPECT_THAT(get("/", "Cookie: xodom_token=" + right + "\r\n"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(get("/metrics", "Authorization: Bearer " + right + "\r\n"),
              StartsWith("HTTP/1.1 200"));
  // The token does not admit a page of another site.
  EXPECT_THAT(get("/?token=" + right, "Origin: http://other.example\r\n"),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(proc("cmdline"), Not(HasSubstr(right)));
  EXPECT_THAT(server_->errors(), Not(HasSubstr(right)));
}

TEST(ServeCommand, RefusesWhatIsNotSafeOrNotUsable) {
  const Scratch scratch;
  const auto token_file = [&](const char* name, const std::string& text, unsigned mode) {
    const auto file = scratch.write(name, text);
    std::filesystem::permissions(file, std::filesystem::perms{mode});
    return " --token-file " + file.string();
  };
  const std::string good{token};
  expect_refused("timeout 20 odom serve ",
                 {{"--listen 0.0.0.0", HasSubstr("so it needs a --token-file")},
                  {"--listen [::]:0", HasSubstr("so it needs a --token-file")},
                  {"--listen 192.168.1.5:80", HasSubstr("so it needs a --token-file")},
                  {"--listen example.org", HasSubstr("not ADDR[:PORT]")},
                  {"--listen 127.0.0.1:65536", HasSubstr("not ADDR[:PORT]")},
                  {"--listen 127.0.0.1:", HasSubstr("not ADDR[:PORT]")},
                  {"--listen 127.0.0.1:12x", HasSubstr("not ADDR[:PORT]")},
                  {"--listen ''", HasSubstr("is empty")},
                  {"--listen 127.0.0.1:0" + token_file("a", good, 0644), HasSubstr("chmod 0640")},
                  {"--listen 127.0.0.1:0" + token_file("b", good, 0660), HasSubstr("mode 0660")},
                  {token_file("c", "short\n", 0600), HasSubstr("16 to 128 letters")},
                  {token_file("d", good + "\nsecond line\n", 0600), HasSubstr("16 to 128")},
                  {token_file("e", good + "; Path", 0600), HasSubstr("16 to 128")},
                  {token_file("f", std::string(300, 'a'), 0600), HasSubstr("16 to 128")},
                  {"--token-file " + scratch.path("none").string(), HasSubstr("No such file")},
                  {"--token-file " + scratch.path("").string(), HasSubstr("not a file")}});
  EXPECT_THAT(
      run_shell("timeout 20 odom serve --listen 203.0.113.1:9 " + token_file("g", good, 0400)),
      Ends(1, HasSubstr("cannot listen at 203.0.113.1 port 9")));
}

TEST_F(Serve, ASecondOneDoesNotShareThePort) {
  start();
  EXPECT_THAT(run_shell("timeout 20 odom serve --listen 127.0.0.1:" + std::to_string(port_)),
              Ends(1, HasSubstr("Address already in use")));
}

std::string ranges(int count) {
  std::string header = "Range: bytes=0-1";
  for (int i = 0; i < count; ++i) header += ",0-";
  return header;
}

TEST_F(Serve, SurvivesBrokenRequests) {
  start();
  const std::string valid =
      "GET /history HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-1,2-3\r\nCookie: a=b\r\n\r\n";
  std::mt19937 random{1};
  for (int i = 0; i < 300; ++i) {
    std::string request = valid;
    for (int change = 0; change <= i % 8; ++change) {
      const std::size_t at = random() % request.size();
      if (random() % 4 == 0)
        request.insert(at, random() % 64, static_cast<char>(random() % 256));
      else
        request[at] = static_cast<char>(random() % 256);
    }
    Client client{port_};
    client.send(request + "\r\n\r\n");
    client.end();
    client.receive();
  }
  const std::string many = get("/page.js", ranges(400) + "\r\n");
  EXPECT_THAT(many, AllOf(StartsWith("HTTP/1.1 200"), Not(HasSubstr("multipart"))));
  const long before_kb = resident_kb();
  // Endless headers are refused after 16 kB, not collected.
  std::string endless = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  while (endless.size() < 8'000'000) endless += "X-Filler: " + std::string(1000, 'x') + "\r\n";
  EXPECT_THAT(answer_to(endless), Not(HasSubstr("200 OK")));
  (void)answer_to("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n" +
                  endless);
  EXPECT_LT(resident_kb() - before_kb, 4000);
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(server_->terminate().status, 0) << server_->errors();
}

// A regular expression used stack for each character here, in each of 80 threads.
TEST_F(Serve, ReadsNoLongLines) {
  start_with_token();
  const long before_kb = resident_kb();
  for (const auto& [headers, status] : std::vector<std::pair<std::string, std::string>>{
           {"Host: evil.example\r\n" + ranges(2600), "400"},
           {"Host: " + std::string(7000, '1'), "400"},
           {"Host: localhost\r\nX-Long: " + std::string(1600, 'x'), "400"},
           {"Host: " + std::string(1500, '1'), "403"},
           {"Host: evil.example\r\nRange: bytes=" + std::string(1500, '0'), "416"}}) {
    std::vector<std::unique_ptr<Client>> strangers;
    for (int i = 0; i < 100; ++i) {
      strangers.push_back(std::make_unique<Client>(port_));
      strangers.back()->send("GET / HTTP/1.1\r\n" + headers + "\r\n\r\n");
    }
    for (const auto& stranger : strangers)
      ASSERT_THAT(stranger->receive(), StartsWith("HTTP/1.1 " + status)) << headers;
  }
  EXPECT_LT(resident_kb() - before_kb, 80'000);  // the service may use 128 MB
  const std::string cookie = "Cookie: other=" + std::string(1400, 'x') + "; odom_token=";
  EXPECT_THAT(get("/", cookie + std::string{token} + "\r\n"), StartsWith("HTTP/1.1 200"));
}

TEST_F(Serve, EndsARequestThatNeverEnds) {
  start();
  const auto begin = steady_clock::now();
  std::vector<std::unique_ptr<Client>> idle;
  for (int i = 0; i < 10; ++i) {
    idle.push_back(std::make_unique<Client>(port_));
    idle.back()->send("GET / HT");
  }
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  for (const auto& client : idle) client->receive();
  EXPECT_LT(steady_clock::now() - begin, milliseconds{6000});
}

std::vector<long> ids_in(const std::string& stream) {
  std::vector<long> ids;
  for (std::size_t at = 0; (at = stream.find("\nid: ", at)) != std::string::npos; at += 5)
    ids.push_back(std::stol(stream.substr(at + 5)));
  return ids;
}

TEST_F(Serve, FiftyViewersOfWhomTenAreStalled) {
  SlowDaemon daemon{segment()};
  const AnsweringSocket status{scratch_.path("status.sock").string(), status_text};
  daemon.tick();
  start();
  const long before_kb = resident_kb();
  std::vector<std::unique_ptr<Client>> viewers;
  const auto add_viewer = [&](int receive_buffer) -> Client& {
    viewers.push_back(std::make_unique<Client>(port_, receive_buffer));
    viewers.back()->send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n");
    return *viewers.back();
  };
  for (int i = 0; i < 10; ++i) add_viewer(2048);
  for (int i = 10; i < 64; ++i)
    ASSERT_THAT(add_viewer(0).receive("\n\n"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(get("/events"), StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  viewers.resize(50);
  const auto end = steady_clock::now() + milliseconds{12'000};
  while (steady_clock::now() < end) {
    for (std::size_t i = 10; i < viewers.size(); ++i) viewers[i]->receive_what_came();
    std::this_thread::sleep_for(milliseconds{100});
  }
  for (std::size_t i = 10; i < viewers.size(); ++i) {
    const std::vector<long> ids = ids_in(viewers[i]->receive_what_came());
    ASSERT_GT(ids.size(), 150U);
    for (std::size_t k = 1; k < ids.size(); ++k) ASSERT_EQ(ids[k], ids[k - 1] + 1) << i;
  }
  EXPECT_LT(resident_kb() - before_kb, 8000);
  // The stalled viewers were dropped: their places are free.
  for (int i = 0; i < 24; ++i)
    EXPECT_THAT(add_viewer(0).receive("\n\n"), StartsWith("HTTP/1.1 200")) << i;
  EXPECT_EQ(server_->terminate().status, 0);
}

TEST_F(Serve, FollowsADaemonThatComesGoesAndIsReplaced) {
  start();
  EXPECT_THAT(stream_until("WAITING"), HasSubstr("WAITING"));
  EXPECT_THAT(get("/metrics"), HasSubstr("\nodom_up 0\n# EOF\n"));
  auto daemon = std::make_unique<SlowDaemon>(segment(), 50'000'000);
  daemon->pose.x = 1.25;
  daemon->tick();
  EXPECT_THAT(stream_until("\"live\":true"), HasSubstr("1.2500"));
  EXPECT_THAT(stream_until("SILENT"), HasSubstr("\"live\":false"));
  daemon.reset();
  daemon = std::make_unique<SlowDaemon>(segment());
  daemon->pose.x = 7.5;
  daemon->tick();
  EXPECT_THAT(stream_until("7.5000"),
              HasSubstr(",2.0000,7.5000,"));  // a new section of the trail
  EXPECT_THAT(stream_until("has restarted"), HasSubstr("odomd has restarted 1 time meanwhile"));
}

TEST_F(Serve, SaysThatASegmentHasAnotherAbi) {
  std::ofstream(segment(), std::ios::binary) << std::string(4096, 'x');
  start();
  EXPECT_THAT(stream_until("ABI"), HasSubstr("ABI"));
}

TEST_F(Serve, MapsNothingOfTheSegmentWritable) {
  SlowDaemon daemon{segment()};
  daemon.tick();
  start();
  ASSERT_THAT(stream_until("TRACKING"), HasSubstr("TRACKING"));
  std::istringstream maps{proc("maps")};
  int found = 0;
  for (std::string line; std::getline(maps, line);) {
    if (line.find(segment()) != std::string::npos) {
      ++found;
      EXPECT_THAT(line, HasSubstr(" r--s "));
    } else if (line.find(" rw-s ") != std::string::npos) {
      ADD_FAILURE() << "shared and writable: " << line;
    }
  }
  EXPECT_GT(found, 0);
}

// tests/campaign/serve.sh gives the text to Prometheus' own parsers.
TEST_F(Serve, GivesTheMetricsOfOdomStatus) {
  const AnsweringSocket status{scratch_.path("status.sock").string(), status_text};
  start();
  const std::string socket = " --socket " + scratch_.path("status.sock").string();
  const Outcome printed = run_shell("odom status --openmetrics" + socket);
  EXPECT_THAT(printed, Ends(0, IsEmpty()));
  EXPECT_TRUE(printed.out.ends_with("\n# EOF\n"));
  for (const char* line :
       {"odom_up 1\n", "odom_mode{mode=\"tracking\"} 1\n", "odom_ticks_total 1000\n",
        "odom_condition{condition=\"sensor_fault\"} 1\n", "odom_pose_jumps_total 2\n",
        "odom_tick_lateness_seconds{statistic=\"max\"} 0.0009\n",
        "odom_can_frames_total{bus=\"can\\\"0\\\\\\n\"} 7\n",
        "odom_source_healthy{source=\"camera\"} 0\n",
        "odom_source_samples_total{source=\"camera\",verdict=\"gated\"} 1\n"})
    EXPECT_THAT(printed.out,
                AllOf(HasSubstr(line), Not(HasSubstr("motor")), Not(HasSubstr("sigma_x"))));
  ASSERT_TRUE(eventually([&] { return get("/metrics").ends_with(printed.out); }));
  EXPECT_THAT(get("/metrics"), HasSubstr("application/openmetrics-text; version=1.0.0"));
  EXPECT_THAT(stream_until("frozen"), HasSubstr(R"(["camera","frozen",false,)"));
}

TEST(OpenMetrics, WithoutADaemonSaysSo) {
  const Outcome printed = run_shell("odom status --openmetrics --socket nowhere.sock");
  EXPECT_THAT(printed, Ends(0, HasSubstr("nowhere.sock: no such socket")));
  EXPECT_THAT(printed.out, HasSubstr("\nodom_up 0\n# EOF\n"));
}

TEST_F(Serve, SaysThatAStatusIsNotUnderstood) {
  const AnsweringSocket status{scratch_.path("status.sock").string(),
                               R"({"sources": [{"name": "motor", "configured": "maybe"}]})"};
  start();
  EXPECT_THAT(stream_until("same version"), HasSubstr("the status cannot be parsed"));
}

}  // namespace
}  // namespace odomd::tools::serve_test
