#include "tools/studio/server.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <list>
#include <optional>
#include <set>

#include "patinate/core/error.h"

namespace patinate::studio {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using beast::error_code;

/// A connection that has not shown that it may ask.
class Stranger {
 public:
  virtual void turn_away() = 0;

 protected:
  ~Stranger() = default;
};

/// One thread runs the sockets; answers are made by a pool of others. Everything below is touched by the first only,
/// unless it says so.
struct HttpServer::State {
  explicit State(const ServerOptions& given) : options(given), acceptor(io) {}

  ServerOptions options;
  ServerHandlers handlers;
  std::set<std::stop_source*> in_flight;
  std::list<Stranger*> strangers;  ///< Oldest first.
  int num_known = 0, num_uploads = 0;
  bool is_stopping = false;
  asio::io_context io{1};  ///< Behind what open connections touch when it ends.
  tcp::acceptor acceptor;
  std::optional<asio::thread_pool> workers;
};

namespace {

constexpr std::string_view kServerName = "patinate";

/// Counts a connection that is known while it lives.
class Place {
 public:
  explicit Place(int& count) : count_(count) { ++count_; }
  ~Place() { --count_; }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

 private:
  int& count_;
};

/// Among the strangers while it lives. Whoever comes when all their places are taken, gets that of the one who has
/// waited longest: however many only sit there, one who shows a token at once is heard.
class StrangersPlace {
 public:
  StrangersPlace(HttpServer::State& state, Stranger& stranger) : strangers_(state.strangers) {
    if (strangers_.size() >= static_cast<std::size_t>(state.options.num_strangers)) strangers_.front()->turn_away();
    at_ = strangers_.insert(strangers_.end(), &stranger);
  }
  ~StrangersPlace() { strangers_.erase(at_); }
  StrangersPlace(const StrangersPlace&) = delete;
  StrangersPlace& operator=(const StrangersPlace&) = delete;

 private:
  std::list<Stranger*>& strangers_;
  std::list<Stranger*>::iterator at_;
};

HttpRequest plain(const http::request<http::string_body>& request) {
  HttpRequest out;
  out.method = std::string(request.method_string());
  out.target = std::string(request.target());
  for (const auto& field : request) {
    std::string name(field.name_string());
    std::transform(name.begin(), name.end(), name.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    std::string& value = out.headers[name];
    if (!value.empty()) value += ", ";
    value += std::string(field.value());
  }
  out.body = request.body();
  return out;
}

/// A WebSocket: what comes goes to the listener, what is sent waits in line.
class Socket : public WebSocketPeer, public std::enable_shared_from_this<Socket> {
 public:
  Socket(tcp::socket socket, asio::io_context& io, std::size_t max_message_bytes, std::shared_ptr<Place> place)
      : io_(io), stream_(std::move(socket)), place_(std::move(place)) {
    stream_.read_message_max(max_message_bytes);
    stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    stream_.auto_fragment(false);
  }

  void open(const http::request<http::string_body>& request, const ServerHandlers& handlers) {
    const auto asked = std::make_shared<http::request<http::string_body>>(request);
    stream_.async_accept(*asked, [self = shared_from_this(), asked, open = handlers.open](error_code error) {
      if (error) return;
      self->listener_ = open(plain(*asked), self);
      if (!self->listener_) return self->close();
      self->read();
    });
  }

  void send_text(std::string message) override { send({std::move(message), false}); }
  void send_binary(std::string message) override { send({std::move(message), true}); }
  [[nodiscard]] std::size_t num_waiting_bytes() const override { return num_waiting_; }
  void close() override { close_with(websocket::close_code::normal); }
  void refuse(const std::string& why) override {
    constexpr std::size_t kMaxReason = 120;  // 123 by RFC 6455
    std::size_t length = std::min(why.size(), kMaxReason);
    while (length > 0 && length < why.size() && (static_cast<unsigned char>(why[length]) & 0xC0) == 0x80)
      --length;  // no half character
    close_with({static_cast<websocket::close_code>(kRefused), why.substr(0, length)});
  }

 private:
  void close_with(const websocket::close_reason& reason) {
    asio::post(io_, [self = shared_from_this(), reason] {
      if (self->is_closed_) return;
      self->is_closed_ = true;
      self->reason_ = reason;
      if (self->waiting_.empty()) self->say_close();
    });
  }

  struct Message {
    std::string bytes;
    bool is_binary = false;
  };

  void send(Message message) {
    num_waiting_ += message.bytes.size();
    asio::post(io_, [self = shared_from_this(), message = std::move(message)]() mutable {
      if (self->is_closed_) return;
      self->waiting_.push_back(std::move(message));
      if (self->waiting_.size() == 1) self->write();
    });
  }

  void write() {
    stream_.binary(waiting_.front().is_binary);
    stream_.async_write(asio::buffer(waiting_.front().bytes),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          if (error) return self->end();
                          self->num_waiting_ -= self->waiting_.front().bytes.size();
                          self->waiting_.pop_front();
                          if (!self->waiting_.empty()) return self->write();
                          if (self->is_closed_) self->say_close();
                        });
  }

  void say_close() {
    stream_.async_close(reason_, [self = shared_from_this()](error_code) { self->end(); });
  }

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->end();
      std::string text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (self->listener_) self->listener_->received(std::move(text));
      self->read();
    });
  }

  void end() {
    is_closed_ = true;
    if (const std::shared_ptr<WebSocketListener> listener = std::exchange(listener_, nullptr)) listener->closed();
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
  }

  asio::io_context& io_;
  websocket::stream<beast::tcp_stream> stream_;
  std::shared_ptr<Place> place_;
  beast::flat_buffer buffer_;
  std::deque<Message> waiting_;
  std::atomic<std::size_t> num_waiting_{0};
  std::shared_ptr<WebSocketListener> listener_;
  websocket::close_reason reason_ = websocket::close_code::normal;
  bool is_closed_ = false;
};

/// A connection that asks one thing after the other.
class Connection final : public Stranger, public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, HttpServer::State& state) : state_(state), stream_(std::move(socket)) {
    stranger_.emplace(state_, *this);
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(state_.options.max_header_bytes));
    uploading_.reset();
    parser_->body_limit(state_.options.max_upload_bytes);  // less, once it is known what comes
    stream_.expires_after(std::chrono::seconds(known_ ? state_.options.timeout_s : state_.options.stranger_timeout_s));
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (!self->is_readable(error)) return;
      self->have_header();
    });
  }

  void turn_away() override {
    stranger_.reset();
    stream_.close();
  }

 private:
  /// False where there is nothing to continue with; whoever can be told has been told.
  bool is_readable(error_code error) {
    if (error == http::error::header_limit)
      reject(431, "the request's header is too long");
    else if (error == http::error::body_limit)
      reject(413, "the request is too large");
    else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
             error != http::error::end_of_stream && error != http::error::partial_message)
      reject(400, "this is no HTTP request");
    else if (error)
      shut();
    return !error;
  }

  /// Who asks is looked at before what comes with it is read.
  void have_header() {
    if (HttpResponse refusal = state_.handlers.admit(plain(parser_->get())); refusal.status != 0) {
      known_.reset();
      if (!stranger_) stranger_.emplace(state_, *this);
      return write(std::move(refusal), parser_->is_done() && parser_->get().keep_alive());
    }
    if (!known_) {
      if (state_.num_known >= state_.options.num_known)
        return reject(503, "too many connections are open; close some pages of the studio");
      known_ = std::make_shared<Place>(state_.num_known);
      stranger_.reset();
    }
    const std::size_t num_bytes = parser_->content_length().value_or(0);
    if (state_.handlers.is_upload && state_.handlers.is_upload(plain(parser_->get()))) {
      if (state_.num_uploads >= state_.options.num_uploads)
        return reject(503, "other files are on their way; try again when they have come");
      uploading_ = std::make_shared<Place>(state_.num_uploads);
    } else {
      if (num_bytes > state_.options.max_body_bytes) return reject(413, "the request is too large");
      parser_->body_limit(state_.options.max_body_bytes);
    }
    stream_.expires_after(std::chrono::seconds(state_.options.timeout_s) + time_for(num_bytes));
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code error, std::size_t) {
      if (!self->is_readable(error)) return;
      self->have_read();
    });
  }

  void have_read() {
    if (state_.handlers.open && websocket::is_upgrade(parser_->get())) {
      stream_.expires_never();
      const auto socket =
          std::make_shared<Socket>(stream_.release_socket(), state_.io, state_.options.max_message_bytes, known_);
      return socket->open(parser_->get(), state_.handlers);
    }
    answer(plain(parser_->get()));
  }

  void answer(const HttpRequest& request) {
    stream_.expires_never();
    gone_ = std::stop_source();
    state_.in_flight.insert(&gone_);
    watch_for_end();
    asio::post(*state_.workers, [self = shared_from_this(), request, gone = gone_.get_token()] {
      HttpResponse response = self->state_.handlers.answer(request, gone);
      asio::post(self->state_.io, [self, response = std::move(response)]() mutable {
        self->state_.in_flight.erase(&self->gone_);
        self->is_answered_ = true;
        error_code ignored;
        self->stream_.socket().cancel(ignored);
        self->write(std::move(response), self->parser_->get().keep_alive());
      });
    });
  }

  /// A client that closes its end while its answer is made does not want it any more.
  void watch_for_end() {
    is_answered_ = false;
    stream_.socket().async_wait(tcp::socket::wait_read, [self = shared_from_this()](error_code error) {
      if (error || self->is_answered_) return;
      error_code peeked;
      if (self->stream_.socket().available(peeked) == 0)
        self->gone_.request_stop();  // readable, and nothing to read: the end
    });
  }

  /// Of slow connections: 100 kB a second.
  static std::chrono::milliseconds time_for(std::size_t num_bytes) {
    return std::chrono::milliseconds(num_bytes / 100);
  }

  void reject(int status, const std::string& text) { write({.status = status, .body = text + "\n"}, false); }

  void write(HttpResponse response, bool keep_alive) {
    if (state_.is_stopping) keep_alive = false;
    const auto message = std::make_shared<http::response<http::string_body>>();
    message->version(11);
    message->result(static_cast<unsigned>(response.status));
    message->set(http::field::server, beast::string_view(kServerName.data(), kServerName.size()));
    message->set(http::field::content_type, response.type);
    for (const auto& [name, value] : response.headers) message->set(name, value);
    message->body() = std::move(response.body);
    message->keep_alive(keep_alive);
    message->prepare_payload();
    stream_.expires_after(std::chrono::seconds(known_ ? state_.options.timeout_s : state_.options.stranger_timeout_s) +
                          time_for(message->body().size()));
    http::async_write(stream_, *message,
                      [self = shared_from_this(), message, keep_alive](error_code error, std::size_t) {
                        if (error || !keep_alive) return self->shut();
                        self->read();
                      });
  }

  void shut() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.close();
  }

  HttpServer::State& state_;
  beast::tcp_stream stream_;
  std::optional<StrangersPlace> stranger_;  ///< Exactly one of these two is there while it is open.
  std::shared_ptr<Place> known_, uploading_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::stop_source gone_;
  bool is_answered_ = false;
};

void accept(HttpServer::State& state) {
  state.acceptor.async_accept([&state](error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !state.acceptor.is_open()) return;
    if (!error) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(std::move(socket), state)->read();
    }
    accept(state);
  });
}

}  // namespace

HttpServer::HttpServer(const ServerOptions& options) : state_(std::make_unique<State>(options)) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), static_cast<unsigned short>(options.port));
  error_code error;
  tcp::acceptor& acceptor = state_->acceptor;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw CannotComplete("port " + std::to_string(options.port) + ": " + error.message() +
                         "; give another with --port, or 0 for any that is free");
}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return state_->acceptor.local_endpoint().port(); }

void HttpServer::run(const ServerHandlers& handlers, const std::stop_token& stop_token) {
  State& s = *state_;
  s.handlers = handlers;
  s.workers.emplace(static_cast<std::size_t>(s.options.num_workers));
  const std::stop_callback on_stop(stop_token, [this] { stop(); });
  accept(s);
  s.io.run();
  for (std::stop_source* source : s.in_flight) source->request_stop();
  s.workers->join();
}

void HttpServer::stop() {
  // An answer in progress (the request to end, perhaps) has a moment to be sent.
  asio::post(state_->io, [s = state_.get()] {
    s->is_stopping = true;
    error_code ignored;
    s->acceptor.close(ignored);
    for (std::stop_source* source : s->in_flight) source->request_stop();
    const auto timer = std::make_shared<asio::steady_timer>(s->io, std::chrono::milliseconds(200));
    timer->async_wait([s, timer](error_code) { s->io.stop(); });
  });
}

}  // namespace patinate::studio
