// The page, its events and the metrics over HTTP. Each viewer has its own thread, which sends the
// shared events; a slow viewer skips events, and nobody waits for it.
#pragma once

#include <httplib.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <regex>
#include <string>
#include <thread>

#include "tools/serve/options.hpp"

namespace odomd::serve {

class Server final : private httplib::Server {
 public:
  static constexpr int max_viewers = 64;  ///< further viewers get 503

  /// Listens from now on. Throws std::runtime_error if it cannot.
  explicit Server(Endpoint endpoint);
  ~Server() override;

  [[nodiscard]] int port() const { return endpoint_.port; }
  /// False after an error of the listening socket.
  [[nodiscard]] bool is_listening() const { return !ended_; }
  /// Sends the event to all viewers; new viewers begin with the last event that `is_start`.
  void publish(std::string event, bool is_start);
  /// Sets the answers of /history and /metrics.
  void set_answers(std::string history, std::string metrics);

 private:
  using Event = std::shared_ptr<const std::string>;

  bool process_and_close_socket(socket_t socket) override;
  HandlerResponse guard(const httplib::Request& request, httplib::Response& response) const;
  void add_routes();
  void open_stream(const httplib::Request& request, httplib::Response& response);
  [[nodiscard]] Event wait_for(std::uint64_t& next);

  Endpoint endpoint_;
  std::regex own_hosts_;
  std::atomic<int> viewers_ = 0;
  std::mutex mutex_;  // protects all members below except the thread
  std::condition_variable published_;
  std::deque<Event> recent_;
  std::uint64_t count_ = 0;  // events so far
  std::uint64_t start_ = 0;  // number of the event with which new viewers begin
  std::string history_;
  std::string metrics_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

}  // namespace odomd::serve
