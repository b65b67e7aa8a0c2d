#include "cpplus/pipeline/view_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "cpplus/core/error.h"
#include "cpplus/core/interrupt.h"

namespace cpplus {
namespace {

constexpr const char* kHost = "127.0.0.1";

// How often a running server looks whether it is to stop.
constexpr std::chrono::milliseconds kStopCheck(100);

// Stops a server when the user asks for it (core/interrupt.h).
class StopWatch {
 public:
  explicit StopWatch(httplib::Server* server)
      : thread_([this, server] {
          for (; !ended_; std::this_thread::sleep_for(kStopCheck)) {
            if (interrupt_requested()) server->stop();  // again where it did not listen yet
          }
        }) {}
  ~StopWatch() {
    ended_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

bool names_this_machine(const std::string& host) {
  const std::string name = host.substr(0, host.find(':'));
  return name == kHost || name == "localhost";
}

}  // namespace

void serve_view(const std::string& folder, int port, const std::function<std::vector<uint8_t>(size_t)>& make_photo,
                const std::function<void(const std::string& address)>& on_ready) {
  httplib::Server server;
  server.set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
    if (names_this_machine(request.get_header_value("Host"))) return httplib::Server::HandlerResponse::Unhandled;
    response.status = 403;
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_file_extension_and_mimetype_mapping("pnts", "application/octet-stream");
  server.set_mount_point("/", folder);
  server.Get(R"(/photos/(\d{1,9})\.jpg)", [&](const httplib::Request& request, httplib::Response& response) {
    const std::vector<uint8_t> jpeg = make_photo(std::stoul(request.matches[1].str()));
    response.status = jpeg.empty() ? 404 : 200;
    response.set_content(std::string(jpeg.begin(), jpeg.end()), "image/jpeg");
  });
  const int bound = port == 0 ? server.bind_to_any_port(kHost) : (server.bind_to_port(kHost, port) ? port : -1);
  if (bound < 0)
    throw Error(fmt::format("{}:{}: cannot listen there; is the port taken? (--port 0 finds one)", kHost, port));
  on_ready(fmt::format("http://{}:{}/", kHost, bound));
  const StopWatch watch(&server);
  const bool ended_well = server.listen_after_bind();
  check_interrupt();
  if (!ended_well) throw Error(fmt::format("{}:{}: the server stopped", kHost, bound));
}

}  // namespace cpplus
