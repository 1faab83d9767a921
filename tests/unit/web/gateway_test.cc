// The gateway against a client that knows HTTP and the gRPC-Web specification, and none of our
// code.

#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/error_detail.pb.h"
#include "driftwise/v1/run_service.pb.h"
#include "server/web/base64.h"
#include "tests/unit/web/web_fixture.h"

namespace driftwise::tests {
namespace {

using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

const std::string kCell = "/driftwise.v1.CellService/";

class Gateway : public WebTest {
 protected:
  Gateway() { fakes.feeds = &feeds; }
  EventId add_event(const std::string& what) {
    EventRecord event;
    event.what = what;
    event.id = cell.add_event(what);
    cell.on_executor([&] { feeds.events.publish(event); });
    return event.id;
  }
  FakeFeeds feeds;
  GrpcWebReply call(const std::string& method, const std::string& message,
                    const std::string& headers = {}) {
    HttpClient client(address());
    const auto reply = client.post(method, kGrpcWeb + headers, framed(message));
    EXPECT_EQ(reply.status, 200) << reply.body;
    EXPECT_EQ(reply.header("content-type"), "application/grpc-web+proto");
    return unframed(reply.body);
  }
};

TEST_F(Gateway, AnswersAUnaryCallWithItsMessageAndTrailers) {
  const auto reply = call(kCell + "GetStatus", "");
  ASSERT_THAT(reply.messages, SizeIs(1));
  v1::GetStatusResponse status;
  ASSERT_TRUE(status.ParseFromString(reply.messages[0]));
  EXPECT_EQ(status.cell_name(), "small");
  EXPECT_EQ(reply.status, 0);
}

TEST_F(Gateway, LosesNoAnswerHoweverQuickTheServiceIs) {
  HttpClient client(address());
  for (int i = 0; i < 500; ++i) {
    const auto reply = unframed(client.post(kCell + "GetStatus", kGrpcWeb, framed("")).body);
    ASSERT_THAT(reply.messages, SizeIs(1)) << "call " << i;
    ASSERT_EQ(reply.status, 0);
  }
}

TEST_F(Gateway, SpeaksTheTextFormInBase64) {
  HttpClient client(address());
  const auto reply = client.post(kCell + "GetStatus", "Content-Type: application/grpc-web-text\r\n",
                                 web::base64_encode(framed("")));
  EXPECT_EQ(reply.header("content-type"), "application/grpc-web-text+proto");
  const auto bytes = web::base64_decode(reply.body);
  ASSERT_TRUE(bytes);
  EXPECT_THAT(unframed(*bytes).messages, SizeIs(1));
  EXPECT_EQ(unframed(*bytes).status, 0);
}

TEST_F(Gateway, CarriesTheReasonOfAnErrorInItsTrailers) {
  v1::GetRunRequest request;
  request.set_run_id(99);
  const auto reply = call("/driftwise.v1.RunService/GetRun", request.SerializeAsString());
  EXPECT_THAT(reply.messages, SizeIs(0));
  EXPECT_EQ(reply.status, 5);  // NOT_FOUND
  const auto at = reply.trailers.find("grpc-status-details-bin: ");
  ASSERT_NE(at, std::string::npos) << reply.trailers;
  const auto text = reply.trailers.substr(at + 25, reply.trailers.find("\r\n", at) - at - 25);
  v1::ErrorStatus status;
  ASSERT_TRUE(status.ParseFromString(web::base64_decode(text).value_or("")));
  v1::ErrorDetail detail;
  ASSERT_TRUE(status.details_size() == 1 && status.details(0).UnpackTo(&detail));
  EXPECT_EQ(detail.reason(), "NO_SUCH_RUN");
}

TEST_F(Gateway, NamesTheCallerAndTheAddressOfTheBrowser) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  call(kCell + "StopAll", "", "driftwise-operator: ada\r\n");
  EXPECT_EQ(cell.last_event("stop")->who, "ada");
  EXPECT_THAT(cell.last_event("stop")->from, StartsWith("ipv4:127.0.0.1:"));
  call(kCell + "TakeLease", "", "driftwise-operator-bin: " + web::base64_encode("Žofie") + "\r\n");
  EXPECT_EQ(cell.last_event("lease.taken")->who, "Žofie");
}

TEST_F(Gateway, RefusesAMovementThatALineHasHeldBack) {
  const auto ago_ms = [](std::int64_t ms) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return "driftwise-heard-ms: " +
           std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(now).count() - ms) +
           "\r\n";
  };
  const auto late = call(kCell + "Home", "", ago_ms(66'000));
  EXPECT_EQ(late.status, 9);  // FAILED_PRECONDITION
  EXPECT_THAT(late.trailers, HasSubstr("66"));
  EXPECT_EQ(call(kCell + "Home", "", ago_ms(0)).status, 7) << "judged by its lease as ever";
  const auto passing = cell.passing();
  EXPECT_EQ(call(kCell + "StopAll", "", ago_ms(66'000)).status, 0) << "a stop is never too late";
}

TEST_F(Gateway, ABrowserCannotSayWhereItSits) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  call(kCell + "StopAll", "", "driftwise-peer: ipv4:1.2.3.4:5\r\n");
  EXPECT_THAT(cell.last_event("stop")->from, StartsWith("ipv4:127.0.0.1:"));
}

TEST_F(Gateway, BytesThatGrpcCallsIllegalInANameDoNotEndTheDaemon) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  call(kCell + "StopAll", "", "driftwise-operator: a\xC5\x99z\r\n");
  EXPECT_THAT(cell.last_event("stop")->who, StartsWith("a"));
}

TEST_F(Gateway, StreamsMessageByMessageAndKeepsTheConnection) {
  HttpClient client(address());
  v1::WatchEventsRequest request;
  request.set_after_event_id(add_event("before").value);
  const std::string body = framed(request.SerializeAsString());
  add_event("one");
  client.send("POST " + kCell + "WatchEvents HTTP/1.1\r\nHost: " + address() + "\r\n" + kGrpcWeb +
              "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  EXPECT_THAT(client.head(), StartsWith("HTTP/1.1 200"));
  v1::WatchEventsResponse event;
  ASSERT_TRUE(event.ParseFromString(unframed(client.next_chunk()).messages.at(0)));
  EXPECT_EQ(event.event().what(), "one");
  add_event("two");
  ASSERT_TRUE(event.ParseFromString(unframed(client.next_chunk()).messages.at(0)));
  EXPECT_EQ(event.event().what(), "two");
}

TEST_F(Gateway, AClosedSocketEndsItsCall) {
  const auto watching = [&] { return feeds.events.now.load(); };
  const auto becomes = [&](int count) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (watching() != count && std::chrono::steady_clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return watching() == count;
  };
  HttpClient client(address());
  const std::string body = framed("");
  client.send("POST " + kCell + "WatchEvents HTTP/1.1\r\nHost: " + address() + "\r\n" + kGrpcWeb +
              "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  client.head();
  EXPECT_TRUE(becomes(1));
  client.close();
  EXPECT_TRUE(becomes(0));
}

TEST_F(Gateway, ADeadlineOfTheClientEndsTheCall) {
  const auto reply = call(kCell + "WatchEvents", "", "grpc-timeout: 50m\r\n");
  EXPECT_EQ(reply.status, 4);  // DEADLINE_EXCEEDED
  EXPECT_EQ(call(kCell + "GetStatus", "", "grpc-timeout: soon\r\n").status, 3);
}

TEST_F(Gateway, SaysWhatIsWrongWithAMalformedFrame) {
  HttpClient client(address());
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "0 bytes"},
      {std::string("\0\0\0\0", 4), "4 bytes"},
      {std::string("\0\0\0\0\x09xx", 7), "a frame of 9 bytes with 2"},
      {std::string("\0\0\0\0\x01xyz", 8), "2 bytes after the message"},
      {std::string("\x01\0\0\0\0", 5), "compressed"},
      {std::string("\x80\0\0\0\0", 5), "no message"}};
  for (const auto& [body, said] : cases) {
    const auto reply = client.post(kCell + "GetStatus", kGrpcWeb, body);
    EXPECT_EQ(unframed(reply.body).status, 3);
    EXPECT_THAT(reply.body, HasSubstr(said));
  }
  const auto reply =
      client.post(kCell + "GetStatus", "Content-Type: application/grpc-web-text\r\n", "!!!!");
  EXPECT_THAT(web::base64_decode(reply.body).value_or(""), HasSubstr("not base64"));
}

TEST_F(Gateway, AMessageThatIsNoMessageIsRefusedByTheService) {
  EXPECT_NE(call("/driftwise.v1.RunService/GetRun", "\xFF\xFF\xFF").status, 0);
}

TEST_F(Gateway, AnUnknownMethodIsUnimplemented) {
  EXPECT_EQ(call(kCell + "MakeCoffee", "").status, 12);
  EXPECT_EQ(call("/driftwise.v1.TeaService/Make", "").status, 12);
}

TEST_F(Gateway, RefusesOtherContentAndOtherMethods) {
  HttpClient client(address());
  EXPECT_EQ(client.post(kCell + "GetStatus", "Content-Type: application/json\r\n", "").status, 415);
  EXPECT_EQ(client.get(kCell + "GetStatus").status, 405);
  EXPECT_EQ(client.post("/driftwise.v1.CellService/Get/../x", kGrpcWeb, framed("")).status, 404);
}

TEST_F(Gateway, ABodyBeyondTheLimitIsRefusedBeforeItIsSent) {
  HttpClient client(address());
  client.send("POST " + kCell + "GetStatus HTTP/1.1\r\nHost: " + address() + "\r\n" + kGrpcWeb +
              "Content-Length: 99000000\r\n\r\n");
  EXPECT_EQ(client.reply().status, 413);
}

TEST_F(Gateway, EndsStreamsWhenTheDaemonEnds) {
  HttpClient client(address());
  const std::string body = framed("");
  client.send("POST " + kCell + "WatchEvents HTTP/1.1\r\nHost: " + address() + "\r\n" + kGrpcWeb +
              "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  client.head();
  http.reset();
  EXPECT_TRUE(client.closed());
}

}  // namespace
}  // namespace driftwise::tests
