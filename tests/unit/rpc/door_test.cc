// The gRPC door under attack, over real sockets on loopback. Each attack is a bounded loop.

#include <arpa/inet.h>
#include <grpcpp/generic/generic_stub.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <thread>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/data_service.grpc.pb.h"
#include "server/access/access.h"
#include "tests/support/process.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using CellStub = v1::CellService::Stub;

std::size_t open_descriptors() {
  std::size_t count = 0;
  for (const auto& one : std::filesystem::directory_iterator("/proc/self/fd"))
    count += !one.path().empty();
  return count;
}

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// A connection that says what HTTP/2 begins with, and nothing more.
class IdleConnection {
 public:
  explicit IdleConnection(const std::string& address) {
    const auto port =
        htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    const bool v6 = address.starts_with("[::1]");
    sockaddr_storage peer{};
    auto& v4_peer = reinterpret_cast<sockaddr_in&>(peer);
    auto& v6_peer = reinterpret_cast<sockaddr_in6&>(peer);
    if (v6) {
      v6_peer.sin6_family = AF_INET6;
      v6_peer.sin6_port = port;
      v6_peer.sin6_addr = in6addr_loopback;
    } else {
      v4_peer.sin_family = AF_INET;
      v4_peer.sin_port = port;
      inet_pton(AF_INET, "127.0.0.1", &v4_peer.sin_addr);
    }
    socket_ = ::socket(peer.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    connected_ = ::connect(socket_, reinterpret_cast<sockaddr*>(&peer),
                           v6 ? sizeof v6_peer : sizeof v4_peer) == 0;
    static constexpr char kPreface[] = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0";
    if (connected_) connected_ = ::send(socket_, kPreface, sizeof kPreface - 1, MSG_NOSIGNAL) > 0;
  }
  IdleConnection(IdleConnection&& other) noexcept
      : socket_(std::exchange(other.socket_, -1)), connected_(other.connected_) {}
  ~IdleConnection() {
    if (socket_ >= 0) ::close(socket_);
  }
  bool connected() const { return connected_; }
  // The other side closed; what it sent before is read away.
  bool closed() const {
    char bytes[4096];
    for (;;) {
      pollfd there{socket_, POLLIN, 0};
      if (::poll(&there, 1, 0) <= 0) return false;
      if (::recv(socket_, bytes, sizeof bytes, 0) <= 0) return true;
    }
  }

 private:
  int socket_ = -1;
  bool connected_ = false;
};

class RpcDoor : public RpcTest {
 protected:
  RpcDoor() { fakes.feeds = &feeds; }
  void tell(const std::string& what) {
    EventRecord event;
    event.id = cell.add_event(what);
    event.what = what;
    cell.on_executor([&] { feeds.events.publish(event); });
  }
  void keeps_the_stream_beside_idle_connections() {
    Call call;
    CellStub stub(channel);
    const auto reader = stub.WatchEvents(&call, {});
    ASSERT_TRUE(eventually([&] { return feeds.events.now == 1; }));
    std::vector<IdleConnection> idle;
    for (int i = 0; i < 300; ++i) idle.emplace_back(server->address());
    EXPECT_TRUE(eventually([&] {
      return std::any_of(idle.begin(), idle.end(), [](const auto& one) { return one.closed(); });
    }));
    tell("still here");
    v1::WatchEventsResponse event;
    ASSERT_TRUE(reader->Read(&event)) << "idle connections made room, not the stream's";
    EXPECT_EQ(event.event().what(), "still here");
    call.TryCancel();
    EXPECT_FALSE(reader->Finish().ok());
  }
  FakeFeeds feeds;
};

TEST_F(RpcDoor, HoldsIdleConnectionsWithinTheQuota) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  const std::size_t before = open_descriptors();
  std::vector<IdleConnection> idle;
  for (int i = 0; i < 400; ++i) idle.emplace_back(server->address());
  EXPECT_TRUE(idle.back().connected());
  const auto still_open = [&] {
    return static_cast<std::size_t>(
        std::count_if(idle.begin(), idle.end(), [](const auto& one) { return !one.closed(); }));
  };
  const std::size_t quota = rpc::ConnectionGate::Quotas{}.per_peer;
  EXPECT_TRUE(eventually([&] { return still_open() <= quota; })) << still_open();
  EXPECT_GE(still_open(), quota - 4) << "and no more than needed is closed";
  EXPECT_TRUE(eventually([&] { return open_descriptors() <= before + 400 + quota + 20; }));
  EXPECT_TRUE(ask(&CellStub::StopAll, {}, "ada")) << "a new client's stop comes in";
}

TEST_F(RpcDoor, KeepsTheConnectionThatHasACall) { keeps_the_stream_beside_idle_connections(); }

class RpcDoorOfIpV6 : public RpcDoor {
 protected:
  RpcDoorOfIpV6() { door_address = "[::1]:0"; }
  void SetUp() override {
    const int socket = ::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in6 where{};
    where.sin6_family = AF_INET6;
    where.sin6_addr = in6addr_loopback;
    const bool there = ::bind(socket, reinterpret_cast<sockaddr*>(&where), sizeof where) == 0;
    ::close(socket);
    if (!there) GTEST_SKIP() << "this computer has no IPv6";
    RpcDoor::SetUp();
  }
};

TEST_F(RpcDoorOfIpV6, KeepsTheConnectionThatHasACall) {
  keeps_the_stream_beside_idle_connections();
}

TEST_F(RpcDoor, KeepsTheStreamsOfPeopleWhereStrangersWatchTheHealth) {
  Call call;
  CellStub stub(channel);
  const auto reader = stub.WatchEvents(&call, {});
  ASSERT_TRUE(eventually([&] { return feeds.events.now == 1; }));
  // Health answers everybody, so nobody known stands behind these.
  struct Watch {
    Call call;
    grpc::CompletionQueue queue;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream;
    grpc::ByteBuffer first;
    bool next() {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    }
  };
  std::vector<std::unique_ptr<Watch>> watches;
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  const grpc::Slice no_bytes("");
  const grpc::ByteBuffer nothing(&no_bytes, 1);
  for (std::size_t i = 0; i < rpc::CallBook::Quotas{}.streams_in_all + 20; ++i) {
    if (i % 60 == 0) {
      grpc::ChannelArguments own;
      own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      channels.push_back(
          grpc::CreateCustomChannel(server->address(), grpc::InsecureChannelCredentials(), own));
    }
    auto watch = std::make_unique<Watch>();
    grpc::GenericStub health(channels.back());
    watch->stream = health.PrepareCall(&watch->call, "/grpc.health.v1.Health/Watch", &watch->queue);
    watch->stream->StartCall(nullptr);
    ASSERT_TRUE(watch->next());
    watch->stream->Write(nothing, nullptr);
    ASSERT_TRUE(watch->next());
    watch->stream->Read(&watch->first, nullptr);
    ASSERT_TRUE(watch->next()) << "stranger " << i << " is served";
    watches.push_back(std::move(watch));
  }
  tell("still here");
  v1::WatchEventsResponse event;
  EXPECT_TRUE(reader->Read(&event)) << "strangers' streams made room, not ada's";
  call.TryCancel();
  reader->Finish();
  for (auto& watch : watches) {
    watch->call.TryCancel();
    watch->queue.Shutdown();
    void* tag = nullptr;
    bool ok = false;
    while (watch->queue.Next(&tag, &ok)) {
    }
  }
}

TEST_F(RpcDoor, GivesEachConnectionOfTheLocalSocketItsOwnStreams) {
  server.reset();
  const TemporaryFolder folder;
  const auto access = *access::Access::open({}, folder.path());
  server = *rpc::RpcServer::open(cell.services(fakes), "127.0.0.1:0", {}, access.get());
  std::vector<std::shared_ptr<grpc::Channel>> channels;
  std::vector<std::unique_ptr<Call>> calls;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::WatchEventsResponse>>> readers;
  for (int i = 0; i < 80; ++i) {
    if (i % 20 == 0) {
      grpc::ChannelArguments own;
      own.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      channels.push_back(grpc::CreateCustomChannel("unix:" + server->socket_path(),
                                                   grpc::InsecureChannelCredentials(), own));
    }
    CellStub stub(channels.back());
    calls.push_back(std::make_unique<Call>());
    readers.push_back(stub.WatchEvents(calls.back().get(), {}));
    ASSERT_TRUE(eventually([&] { return feeds.events.begun == i + 1; }));
  }
  tell("news");
  v1::WatchEventsResponse event;
  int served = 0;
  for (auto& reader : readers) served += reader->Read(&event) ? 1 : 0;
  EXPECT_EQ(served, 80) << "four connections of twenty streams, each within the quota";
  for (auto& call : calls) call->TryCancel();
  for (auto& reader : readers) reader->Finish();
  server.reset();
}

TEST_F(RpcDoor, EndsTheSlowestStreamOfAConnectionBeyondItsQuota) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  const std::size_t quota = rpc::CallBook::Quotas{}.streams_per_connection;
  CellStub stub(channel);
  std::vector<std::unique_ptr<Call>> calls;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::WatchEventsResponse>>> readers;
  v1::WatchEventsResponse event;
  for (std::size_t i = 0; i < quota + 5; ++i) {
    calls.push_back(std::make_unique<Call>());
    readers.push_back(stub.WatchEvents(calls.back().get(), {}));
    // Only a stream that watches can have a message, and none has one before all are there.
    ASSERT_TRUE(eventually([&] { return feeds.events.begun == static_cast<int>(i + 1); }));
    if (i >= quota) {
      EXPECT_FALSE(readers.at(i - quota)->Read(&event)) << "the oldest one";
    }
  }
  EXPECT_TRUE(eventually([&] { return feeds.events.now == static_cast<int>(quota); }));
  tell("news");
  EXPECT_TRUE(readers.back()->Read(&event)) << "the newest one is served";
  EXPECT_TRUE(ask(&CellStub::StopAll, {}, "ada"));
  for (auto& call : calls) call->TryCancel();
  for (auto& reader : readers) reader->Finish();
}

// Streams that end by themselves while the door ends them: each of them is there, or gone.
TEST_F(RpcDoor, ClosesWhileStreamsEnd) {
  for (int round = 0; round < 20; ++round) {
    CellStub stub(channel);
    std::vector<std::unique_ptr<Call>> calls;
    std::vector<std::unique_ptr<grpc::ClientReader<v1::WatchEventsResponse>>> readers;
    const int begun = feeds.events.begun;
    for (int i = 0; i < 60; ++i) {
      calls.push_back(std::make_unique<Call>());
      readers.push_back(stub.WatchEvents(calls.back().get(), {}));
    }
    ASSERT_TRUE(eventually([&] { return feeds.events.begun == begun + 60; }));
    std::thread ending([&] {
      for (auto& call : calls) call->TryCancel();
    });
    TearDown();
    ending.join();
    for (auto& reader : readers) EXPECT_FALSE(reader->Finish().ok());
    SetUp();
  }
}

TEST(CallBook, EndsTheStreamThatBlocksBeforeOneWithoutNews) {
  rpc::CallBook book({.streams_in_all = 2, .streams_per_connection = 2});
  std::string ended;
  const auto enter = [&](const char* name) {
    return book.enter({"ipv4:127.0.0.1:1", true, true}, [&ended, name] { ended += name; });
  };
  auto quiet = enter("quiet ");
  auto blocked = enter("blocked ");
  blocked->message_begun();
  std::this_thread::sleep_for(rpc::CallBook::kSlow + std::chrono::milliseconds(20));
  auto third = enter("third ");
  EXPECT_EQ(ended, "blocked ");
  auto fourth = enter("fourth ");
  EXPECT_EQ(ended, "blocked quiet ");
  EXPECT_EQ(book.known_calls("ipv4:127.0.0.1:1"), 4U);
  blocked.reset();
  EXPECT_EQ(book.known_calls("ipv4:127.0.0.1:1"), 3U);
}

TEST(CallBook, CountsAStreamOfTheGatewayAgainstTheWholeOnly) {
  rpc::CallBook book({.streams_in_all = 3, .streams_per_connection = 1});
  int ended = 0;
  std::vector<std::unique_ptr<rpc::CallBook::Entry>> entries;
  for (int i = 0; i < 3; ++i)
    entries.push_back(book.enter({"", true, true}, [&ended] { ++ended; }));
  EXPECT_EQ(ended, 0);
  entries.push_back(book.enter({"ipv4:127.0.0.1:1", true, true}, [&ended] { ++ended; }));
  EXPECT_EQ(ended, 1);
  EXPECT_EQ(book.streams(), 3U);
}

TEST(CallBook, EndsStreamsThatNobodyKnownHasBegunBeforeThoseOfPeople) {
  rpc::CallBook book({.streams_in_all = 4, .streams_per_connection = 4});
  std::string ended;
  std::vector<std::unique_ptr<rpc::CallBook::Entry>> entries;
  entries.push_back(book.enter({"ipv4:10.0.0.2:1", true, true}, [&ended] { ended += "ada "; }));
  for (int i = 0; i < 20; ++i)
    entries.push_back(book.enter({"ipv4:10.0.0.9:" + std::to_string(i), true, false},
                                 [&ended] { ended += "stranger "; }));
  EXPECT_EQ(ended.find("ada"), std::string::npos) << ended;
  EXPECT_EQ(book.streams(), 4U);
  EXPECT_EQ(book.known_calls("ipv4:10.0.0.9:3"), 0U) << "its connection is nobody's either";
}

TEST(CallBook, TellsConnectionsOfOneNameApart) {
  rpc::CallBook book({.streams_in_all = 9, .streams_per_connection = 2});
  const int one = 1, other = 2;
  int ended = 0;
  std::vector<std::unique_ptr<rpc::CallBook::Entry>> entries;
  for (const int* connection : {&one, &other, &one, &other})
    entries.push_back(book.enter({"unix:", true, true, connection}, [&ended] { ++ended; }));
  EXPECT_EQ(ended, 0) << "two streams of each";
  entries.push_back(book.enter({"unix:", true, true, &one}, [&ended] { ++ended; }));
  EXPECT_EQ(ended, 1);
}

// A client of HTTP/2 by hand: one call whose message of 33 MB comes as fast as the other side lets
// it, and never ends.
class UnfinishedCall {
 public:
  explicit UnfinishedCall(const std::string& address) {
    sockaddr_in peer{};
    peer.sin_family = AF_INET;
    peer.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    inet_pton(AF_INET, "127.0.0.1", &peer.sin_addr);
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&peer), sizeof peer) != 0) return;
    const std::string headers = literal(":method", "POST") + literal(":scheme", "http") +
                                literal(":path", "/driftwise.v1.DataService/ImportDataset") +
                                literal(":authority", "localhost") +
                                literal("content-type", "application/grpc") +
                                literal("te", "trailers");
    send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(4, 0, 0, "") + frame(1, 4, 1, headers));
    data(std::string("\0\1\xf7\x8a\x40", 5));  // 33 000 000 bytes follow, it says
  }
  ~UnfinishedCall() { ::close(socket_); }
  UnfinishedCall(const UnfinishedCall&) = delete;

  // Sends what the windows allow; false when the other side has ended the call.
  bool go_on() {
    static const std::string kPiece(16'384, 'x');
    for (int i = 0; i < 2000 && !ended_; ++i) {
      read_frames();
      const auto room = std::min(connection_window_, stream_window_);
      if (room <= 0 || sent_ >= 32'000'000) break;
      data(kPiece.substr(0, static_cast<std::size_t>(std::min<std::int64_t>(room, 16'384))));
    }
    return !ended_;
  }
  std::int64_t sent() const { return sent_; }

 private:
  static std::string literal(const std::string& name, const std::string& value) {
    return std::string(1, '\0') + static_cast<char>(name.size()) + name +
           static_cast<char>(value.size()) + value;
  }
  static std::string frame(char type, char flags, std::uint32_t stream,
                           const std::string& payload) {
    std::string out;
    for (const int shift : {16, 8, 0}) out += static_cast<char>(payload.size() >> shift & 255U);
    out += type;
    out += flags;
    for (const int shift : {24, 16, 8, 0}) out += static_cast<char>(stream >> shift & 255U);
    return out + payload;
  }
  static std::uint32_t number(std::string_view four) {
    std::uint32_t out = 0;
    for (const char c : four) out = out << 8 | static_cast<unsigned char>(c);
    return out;
  }
  void send(std::string_view bytes) {
    while (!bytes.empty() && !ended_) {
      const auto count = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (count <= 0)
        ended_ = true;
      else
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  void data(const std::string& payload) {
    send(frame(0, 0, 1, payload));
    sent_ += static_cast<std::int64_t>(payload.size());
    connection_window_ -= static_cast<std::int64_t>(payload.size());
    stream_window_ -= static_cast<std::int64_t>(payload.size());
  }
  void read_frames() {
    pollfd there{socket_, POLLIN, 0};
    const int patience_ms = std::min(connection_window_, stream_window_) > 0 ? 0 : 50;
    if (::poll(&there, 1, patience_ms) > 0) {
      char bytes[65'536];
      const auto count = ::recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (count <= 0) {
        ended_ = true;
        return;
      }
      received_.append(bytes, static_cast<std::size_t>(count));
    }
    while (received_.size() >= 9) {
      const std::size_t length = number(received_.substr(0, 3));
      if (received_.size() < 9 + length) return;
      const char type = received_[3], flags = received_[4];
      const std::uint32_t stream = number(received_.substr(5, 4));
      const std::string payload = received_.substr(9, length);
      received_.erase(0, 9 + length);
      if (type == 8) (stream == 0 ? connection_window_ : stream_window_) += number(payload);
      if (type == 3 || type == 7) ended_ = true;                         // RST_STREAM, GOAWAY
      if (type == 6 && (flags & 1) == 0) send(frame(6, 1, 0, payload));  // PING
      if (type != 4 || (flags & 1) != 0) continue;
      for (std::size_t at = 0; at + 6 <= payload.size(); at += 6)
        if (number(payload.substr(at, 2)) == 4) {  // INITIAL_WINDOW_SIZE
          const std::int64_t now = number(payload.substr(at + 2, 4));
          stream_window_ += now - initial_;
          initial_ = now;
        }
      send(frame(4, 1, 0, ""));
    }
  }

  int socket_ = -1;
  bool ended_ = false;
  std::string received_;
  std::int64_t connection_window_ = 65'535, stream_window_ = 65'535, initial_ = 65'535, sent_ = 0;
};

TEST_F(RpcDoor, HoldsABoundedPartOfUnfinishedMessages) {
  const std::size_t before = resident_bytes();
  std::vector<std::unique_ptr<UnfinishedCall>> calls;
  for (int i = 0; i < 16; ++i) calls.push_back(std::make_unique<UnfinishedCall>(server->address()));
  std::size_t most = before;
  for (int round = 0; round < 8; ++round) {
    for (auto& call : calls) call->go_on();
    most = std::max(most, resident_bytes());
  }
  std::int64_t sent = 0;
  for (const auto& call : calls) sent += call->sent();
  EXPECT_GT(sent, 1'000'000) << "the attack came through at all";
#ifndef __SANITIZE_ADDRESS__  // there memory that was given back stays resident for a while
  EXPECT_LT(most - before, rpc::RpcServer::kMostBufferBytes + (std::size_t{100} << 20))
      << sent << " bytes were taken";
#endif
  const auto passing = cell.passing();  // a stop asks the axis twice
  EXPECT_TRUE(ask(&CellStub::StopAll, {}, "ada"));
}

}  // namespace
}  // namespace driftwise::tests
