// odom serve as seen by a browser, an unauthorised client and a broken client.
#include <random>

#include "tests/tools/serve/serve_process.hpp"

namespace odomd::tools::serve_test {
namespace {

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
  EXPECT_EQ(code("/"), "401");
  EXPECT_EQ(code("/metrics"), "401");
  EXPECT_EQ(code("/events"), "401");
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
  EXPECT_EQ(code("/", cookie), "200");
  // The token is removed from the address even if the client has the cookie.
  EXPECT_EQ(code("/?token=" + right, cookie), "303");
  EXPECT_EQ(code("/", "Cookie: xodom_token=" + right + "\r\n"), "401");
  EXPECT_EQ(code("/metrics", "Authorization: Bearer " + right + "\r\n"), "200");
  // The token does not admit a page of another site.
  EXPECT_EQ(code("/?token=" + right, "Origin: http://other.example\r\n"), "403");
  EXPECT_THAT(proc("cmdline"), Not(HasSubstr(right)));
  EXPECT_THAT(server_->errors(), Not(HasSubstr(right)));
}

TEST(ServeCommand, RefusesWhatIsNotSafeOrNotUsable) {
  const Scratch scratch;
  const std::string good{token};
  for (const auto& [name, text, mode] : std::vector<std::tuple<std::string, std::string, unsigned>>{
           {"world", good, 0644},
           {"writable", good, 0660},
           {"short", "short\n", 0600},
           {"lines", good + "\nsecond line\n", 0600},
           {"letters", good + "; Path", 0600},
           {"long", std::string(300, 'a'), 0600},
           {"good", good, 0400}})
    std::filesystem::permissions(scratch.write(name, text), std::filesystem::perms{mode});
  expect_answers(scratch, 2, "timeout 20 odom serve", R"(
--listen 0.0.0.0 -> so it needs a --token-file
--listen [::]:0 -> so it needs a --token-file
--listen 192.168.1.5:80 -> so it needs a --token-file
--listen example.org -> not ADDR[:PORT]
--listen 127.0.0.1:65536 -> not ADDR[:PORT]
--listen 127.0.0.1: -> not ADDR[:PORT]
--listen 127.0.0.1:12x -> not ADDR[:PORT]
--listen '' -> is empty
--listen 127.0.0.1:0 --token-file world -> chmod 0640
--listen 127.0.0.1:0 --token-file writable -> mode 0660
--token-file short -> 16 to 128 letters
--token-file lines -> 16 to 128
--token-file letters -> 16 to 128
--token-file long -> 16 to 128
--token-file none -> No such file
--token-file . -> not a file
)");
  EXPECT_THAT(scratch.run("timeout 20 odom serve --listen 203.0.113.1:9 --token-file good"),
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
  EXPECT_EQ(code("/"), "200");
  EXPECT_EQ(server_->terminate().status, 0) << server_->errors();
}

// A regular expression for these once used stack for each character, in each of 80 threads.
TEST_F(Serve, ReadsNoLongLines) {
  start_with_token();
  const long before_kb = resident_kb();
  for (const auto& [headers, status] : std::vector<std::pair<std::string, std::string>>{
           {"Host: evil.example\r\n" + ranges(2600), "400"},
           {"Host: " + std::string(7000, '1'), "400"},
           {"Host: localhost\r\nX-Long: " + std::string(1600, 'x'), "400"},
           {"Host: " + std::string(1500, '1'), "403"},
           {"Host: evil.example\r\nRange: bytes=" + std::string(1500, '0'), "416"}}) {
    std::vector<Client> strangers;
    for (int i = 0; i < 100; ++i)
      strangers.emplace_back(port_).send("GET / HTTP/1.1\r\n" + headers + "\r\n\r\n");
    for (Client& stranger : strangers)
      ASSERT_THAT(stranger.receive(), StartsWith("HTTP/1.1 " + status)) << headers;
  }
  EXPECT_LT(resident_kb() - before_kb, 80'000);  // the service may use 128 MB
  const std::string cookie = "Cookie: other=" + std::string(1400, 'x') + "; odom_token=";
  EXPECT_EQ(code("/", cookie + std::string{token} + "\r\n"), "200");
}

TEST_F(Serve, EndsARequestThatNeverEnds) {
  start();
  const auto begin = steady_clock::now();
  std::vector<Client> idle;
  for (int i = 0; i < 10; ++i) idle.emplace_back(port_).send("GET / HT");
  EXPECT_EQ(code("/"), "200");
  for (Client& client : idle) client.receive();
  EXPECT_LT(steady_clock::now() - begin, milliseconds{6000});
}

}  // namespace
}  // namespace odomd::tools::serve_test
