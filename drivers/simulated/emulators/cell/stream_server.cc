#include "drivers/simulated/emulators/cell/stream_server.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <cerrno>
#include <cstring>

#include "drivers/simulated/emulators/switches.h"
#include "drivers/simulated/emulators/text.h"

namespace driftwise::simulated {
namespace asio = boost::asio;
using asio::ip::tcp;

namespace {
constexpr std::size_t kMostWaiting = 4 << 20;  // of a client that does not read: then it is cut off
}

// One peer: reads all the time, writes what waits in pieces. Keeps itself alive while an operation
// is under way.
class StreamServer::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(StreamServer& server, Session session)
      : session_(session),
        server_(&server),
        chopper_(server.wire_, server.salt_ + static_cast<std::uint64_t>(session)),
        pause_(server.io_) {}
  virtual ~Connection() = default;

  void start() { read(); }
  void send(std::string bytes) {
    waiting_ += bytes;
    if (waiting_.size() > kMostWaiting) return lost();
    if (!writing_) write();
  }
  void shut() {
    server_ = nullptr;
    pause_.cancel();
    close_stream();
  }
  const Session session_;

 protected:
  using Done = std::function<void(boost::system::error_code, std::size_t)>;
  virtual void read_some(asio::mutable_buffer buffer, Done done) = 0;
  virtual void write_all(asio::const_buffer buffer, Done done) = 0;
  virtual void close_stream() = 0;

 private:
  void read() {
    read_some(asio::buffer(in_), [self = shared_from_this()](auto error, std::size_t size) {
      if (self->server_ == nullptr) return;
      if (error) return self->lost();
      self->server_->handler_.received(self->session_, std::string_view(self->in_.data(), size));
      if (self->server_ != nullptr) self->read();
    });
  }
  void write() {
    writing_ = true;
    const std::size_t size = chopper_.next_piece(waiting_.size());
    out_.assign(waiting_, 0, size);
    waiting_.erase(0, size);
    write_all(asio::buffer(out_), [self = shared_from_this()](auto error, std::size_t) {
      if (self->server_ == nullptr) return;
      if (error) return self->lost();
      if (self->waiting_.empty()) {
        self->writing_ = false;
        return;
      }
      self->pause_.expires_after(self->chopper_.pause());
      self->pause_.async_wait([self](auto) {
        if (self->server_ != nullptr) self->write();
      });
    });
  }
  void lost() {
    StreamServer* server = server_;
    shut();
    if (server != nullptr) server->forget(session_);
  }

  StreamServer* server_;
  WireChopper chopper_;
  asio::steady_timer pause_;
  std::array<char, 4096> in_;
  std::string waiting_, out_;
  bool writing_ = false;
};

class StreamServer::TcpConnection : public Connection {
 public:
  TcpConnection(StreamServer& server, Session session, tcp::socket socket)
      : Connection(server, session), socket_(std::move(socket)) {
    boost::system::error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
  }

 private:
  void read_some(asio::mutable_buffer buffer, Done done) override {
    socket_.async_read_some(buffer, std::move(done));
  }
  void write_all(asio::const_buffer buffer, Done done) override {
    asio::async_write(socket_, buffer, std::move(done));
  }
  void close_stream() override {
    boost::system::error_code ignored;
    socket_.close(ignored);
  }
  tcp::socket socket_;
};

class StreamServer::SerialConnection : public Connection {
 public:
  // slave stays open on our side too: otherwise the line would report a hang-up whenever nobody has
  // it open.
  SerialConnection(StreamServer& server, int master, int slave)
      : Connection(server, 0), stream_(server.io_, master), slave_(slave) {}
  ~SerialConnection() override { ::close(slave_); }

 private:
  void read_some(asio::mutable_buffer buffer, Done done) override {
    stream_.async_read_some(buffer, std::move(done));
  }
  void write_all(asio::const_buffer buffer, Done done) override {
    asio::async_write(stream_, buffer, std::move(done));
  }
  void close_stream() override {
    boost::system::error_code ignored;
    stream_.close(ignored);
  }
  asio::posix::stream_descriptor stream_;
  int slave_;
};

StreamServer::StreamServer(asio::io_context& io, Handler handler, WireOptions wire,
                           std::uint64_t salt)
    : io_(io), handler_(std::move(handler)), wire_(wire), salt_(salt * 1000003) {}

StreamServer::~StreamServer() {
  for (auto& [session, connection] : connections_) connection->shut();
}

std::string StreamServer::listen(const std::string& address, int max_clients) {
  max_clients_ = max_clients;
  const auto colon = address.rfind(':');
  const auto port =
      (colon == std::string::npos ? std::nullopt : parse_integer(address.substr(colon + 1)))
          .value_or(-1);
  std::string host = address.substr(0, colon == std::string::npos ? 0 : colon);
  if (host == "localhost") host = "127.0.0.1";
  boost::system::error_code error;
  const auto ip = asio::ip::make_address(host, error);
  if (error || port < 0 || port > 65535 || !ip.is_loopback())
    throw SetupError("address '" + address +
                     "': expected a loopback address with a port, such as 127.0.0.1:0");
  try {
    acceptor_ =
        std::make_unique<tcp::acceptor>(io_, tcp::endpoint(ip, static_cast<std::uint16_t>(port)));
  } catch (const boost::system::system_error& failure) {
    throw SetupError("address '" + address + "': cannot listen: " + failure.code().message());
  }
  accept();
  return host + ":" + std::to_string(acceptor_->local_endpoint().port());
}

std::string StreamServer::open_serial() {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  std::array<char, 128> name{};
  if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0 ||
      ::ptsname_r(master, name.data(), name.size()) != 0)
    throw SetupError(std::string("cannot open a pseudo-terminal: ") + std::strerror(errno));
  const int slave = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios raw{};
  if (slave < 0 || ::tcgetattr(slave, &raw) != 0)
    throw SetupError(std::string(name.data()) + ": " + std::strerror(errno));
  ::cfmakeraw(&raw);
  ::tcsetattr(slave, TCSANOW, &raw);
  adopt(std::make_shared<SerialConnection>(*this, master, slave), Link::serial);
  return name.data();
}

void StreamServer::accept() {
  acceptor_->async_accept([this](boost::system::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    const bool refused = std::chrono::steady_clock::now() < refuse_until_;
    int clients = 0;
    for (const auto& [session, unused] : connections_) clients += session != 0;
    if (!error && !refused && clients < max_clients_)
      adopt(std::make_shared<TcpConnection>(*this, ++last_session_, std::move(socket)), Link::tcp);
    accept();
  });
}

void StreamServer::adopt(std::shared_ptr<Connection> connection, Link link) {
  connections_[connection->session_] = connection;
  handler_.opened(connection->session_, link);
  connection->start();
}

void StreamServer::forget(Session session) {
  if (connections_.erase(session) > 0) handler_.closed(session);
}

void StreamServer::send(Session session, std::string bytes) {
  const auto found = connections_.find(session);
  if (found != connections_.end()) std::shared_ptr(found->second)->send(std::move(bytes));
}

void StreamServer::drop_all() {
  std::vector<Session> dropped;
  for (auto& [session, connection] : connections_)
    if (session != 0) dropped.push_back(session), connection->shut();
  for (const Session session : dropped) forget(session);
}

}  // namespace driftwise::simulated
