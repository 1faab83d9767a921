// Stop over a WebSocket, against a client that knows RFC 6455 and none of our code.

#include "server/web/stop_socket.h"

#include "driftwise/v1/cell_service.pb.h"
#include "tests/unit/web/web_fixture.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const std::string kStop = "/driftwise.v1.CellService/StopAll";
const std::string kVersion = "Sec-WebSocket-Version: 13\r\n";
// Key and answer of RFC 6455 section 1.3.
const std::string kUpgrade =
    "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
constexpr const char* kAccept = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

class StopSocket : public WebTest {
 protected:
  std::string request(const std::string& target, const std::string& headers) const {
    return "GET " + target + " HTTP/1.1\r\nHost: " + address() + "\r\n" + headers + "\r\n";
  }
  std::string own_page() const { return "Origin: http://" + address() + "\r\n"; }
};

// The payloads of a server's frames, and the code of the one that closes.
struct Frames {
  std::string message;
  int close_code = 0;
};

Frames frames_of(std::string bytes) {
  Frames out;
  bool ended = false;
  while (bytes.size() >= 2) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes.at(i)); };
    const int opcode = byte(0) & 15;
    std::size_t size = byte(1), head = 2;
    if (size == 126) size = static_cast<std::size_t>(byte(2)) << 8 | byte(3), head = 4;
    const std::string payload = bytes.substr(head, size);
    if (opcode == 8) {
      EXPECT_TRUE(ended) << "closed within a message";
      out.close_code = static_cast<unsigned char>(payload.at(0)) << 8 |
                       static_cast<unsigned char>(payload.at(1));
    } else {
      EXPECT_EQ(opcode, out.message.empty() ? 2 : 0);
      out.message += payload;
      ended = (byte(0) & 128) != 0;
    }
    bytes.erase(0, head + size);
  }
  return out;
}

TEST_F(StopSocket, HaltsTheAxesAndAnswersAsThePostDoes) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  HttpClient client(address());
  client.send(request(kStop + "?operator=xb1vZmll", own_page() + kUpgrade + kVersion));
  const HttpReply reply{101, client.head(), ""};
  EXPECT_THAT(reply.head, StartsWith("HTTP/1.1 101 "));
  EXPECT_EQ(reply.header("sec-websocket-accept"), kAccept);
  const auto frames = frames_of(client.rest());
  const auto call = unframed(frames.message);
  ASSERT_EQ(call.messages.size(), 1U);
  v1::StopAllResponse response;
  ASSERT_TRUE(response.ParseFromString(call.messages[0]));
  EXPECT_TRUE(response.confirmed()) << response.message();
  EXPECT_EQ(call.status, 0);
  EXPECT_EQ(frames.close_code, 1000);
  EXPECT_EQ(cell.last_event("stop")->who, "Žofie");
}

TEST_F(StopSocket, IsRefusedToThePageOfAnotherSite) {
  HttpClient client(address());
  client.send(request(kStop, "Origin: http://evil.example\r\n" + kUpgrade + kVersion));
  EXPECT_EQ(client.reply().status, 403);
}

TEST_F(StopSocket, IsTheOnlyOneHereAndNeedsAWholeHandshake) {
  const auto status = [this](const std::string& target, const std::string& headers) {
    HttpClient client(address());
    client.send(request(target, own_page() + headers));
    return client.reply().status;
  };
  EXPECT_EQ(status("/now", kUpgrade + kVersion), 404);
  EXPECT_EQ(status(kStop, "Upgrade: websocket\r\nConnection: Upgrade\r\n" + kVersion), 400);
  EXPECT_EQ(status(kStop, kUpgrade + "Sec-WebSocket-Version: 8\r\n"), 426);
  EXPECT_EQ(status(kStop, ""), 405) << "a plain GET is no stop";
}

TEST_F(StopSocket, StopsAlthoughItsClientLeavesAtOnce) {
  const auto passing = cell.passing();
  {
    HttpClient client(address());
    client.send(request(kStop, own_page() + kUpgrade + kVersion));
    client.head();
  }
  EXPECT_TRUE(cell.last_event("stop"));
  // Its answer is out as well before the clock halts with this test.
  EXPECT_EQ(unframed(HttpClient(address()).post(kStop, kGrpcWeb, framed("")).body).status, 0);
}

class StopSocketOfALockedDoor : public StopSocket {
 protected:
  AccessDescription description() override {
    AccessDescription out;
    out.configured = true;
    out.loopback = LoopbackRule::token;
    return out;
  }
};

TEST_F(StopSocketOfALockedDoor, SaysInItsMessageThatNobodyIsLoggedIn) {
  HttpClient client(address());
  client.send(request(kStop, own_page() + kUpgrade + kVersion));
  EXPECT_THAT(client.head(), StartsWith("HTTP/1.1 101 "));
  EXPECT_EQ(unframed(frames_of(client.rest()).message).status, 16);  // UNAUTHENTICATED
}

}  // namespace
}  // namespace driftwise::tests
