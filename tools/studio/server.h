/// \file
/// HTTP and WebSocket on one port of the loopback interface. Boost.Beast stays in server.cpp.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "tools/studio/http.h"

namespace patinate::studio {

/// One end of a WebSocket, for who talks to it. Calls return at once, from any thread; after the connection has closed
/// they do nothing.
class WebSocketPeer {
 public:
  virtual ~WebSocketPeer() = default;
  virtual void send_text(std::string message) = 0;
  virtual void send_binary(std::string message) = 0;
  /// Bytes that wait to be written.
  [[nodiscard]] virtual std::size_t num_waiting_bytes() const = 0;
  virtual void close() = 0;
  /// Closes with kRefused and as much of the reason as a close message holds.
  virtual void refuse(const std::string& why) = 0;
};
inline constexpr int kRefused = 4400;  ///< Code of a WebSocket that is closed because what it asks for cannot be had.

/// Receiver of messages. Called from one thread; must return at once.
class WebSocketListener {
 public:
  virtual ~WebSocketListener() = default;
  virtual void received(std::string text) = 0;
  virtual void closed() = 0;
};

struct ServerHandlers {
  /// Called for every request, before its body is read and before a WebSocket opens; must return at once. Status 0 = go
  /// on: who sent it is known from then on, until a request of that connection is refused.
  std::function<HttpResponse(const HttpRequest& request)> admit;
  /// Whether a request may bring max_upload_bytes; empty: none may. Called as `admit`, after it.
  std::function<bool(const HttpRequest& request)> is_upload = {};
  /// Called from a few threads at once. `gone` stops when the client has gone or the server ends.
  std::function<HttpResponse(const HttpRequest& request, const std::stop_token& gone)> answer;
  /// A WebSocket has opened. Nothing: it is closed again.
  std::function<std::shared_ptr<WebSocketListener>(const HttpRequest& request, std::shared_ptr<WebSocketPeer> peer)>
      open;
};

struct ServerOptions {
  int port = 0;         ///< 0 = a free one.
  int num_workers = 3;  ///< Requests that are answered at the same time.
  std::size_t max_header_bytes = 16 * 1024;
  std::size_t max_body_bytes = 1024 * 1024;
  std::size_t max_upload_bytes = std::size_t{128} << 20;  ///< Of an upload.
  int num_uploads = 2;                                    ///< At the same time. More are answered with 503.
  std::size_t max_message_bytes = 1024 * 1024;            ///< Most bytes that a WebSocket may bring.
  int num_strangers = 100;     ///< Connections that have shown no token. One more, and the oldest of them is closed.
  int num_known = 100;         ///< Those that have. More are answered with 503 and closed.
  int stranger_timeout_s = 5;  ///< To show a token.
  int timeout_s = 30;          ///< Timeout of those that are known: to send a request, or to take an answer.
};

/// Bound to 127.0.0.1 by its constructor.
class HttpServer {
 public:
  /// @throws CannotComplete if the port cannot be had.
  explicit HttpServer(const ServerOptions& options);
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] int port() const;
  /// Serves until stop() or `stop`; then waits for the answers that are being made.
  void run(const ServerHandlers& handlers, const std::stop_token& stop);
  /// From any thread: what was answered before is still sent.
  void stop();

  struct State;  ///< For server.cpp.

 private:
  std::unique_ptr<State> state_;
};

}  // namespace patinate::studio
