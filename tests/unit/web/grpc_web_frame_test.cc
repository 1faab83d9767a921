#include "server/web/grpc_web_frame.h"

#include <gmock/gmock.h>

#include <random>

#include "server/web/base64.h"
#include "server/web/grpc_web_call.h"

namespace driftwise::web {
namespace {

TEST(Base64, IsThatOfTheRfc) {  // RFC 4648, section 10
  const std::vector<std::pair<std::string, std::string>> vectors = {{"", ""},
                                                                    {"f", "Zg=="},
                                                                    {"fo", "Zm8="},
                                                                    {"foo", "Zm9v"},
                                                                    {"foob", "Zm9vYg=="},
                                                                    {"fooba", "Zm9vYmE="},
                                                                    {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(base64_encode(bytes), text);
    EXPECT_EQ(base64_decode(text), bytes);
    EXPECT_EQ(base64_decode(base64_encode(bytes, false)), bytes);
  }
}

TEST(Base64, TakesPiecesAndRefusesEverythingElse) {
  EXPECT_EQ(base64_decode("Zg==Zm8=Zm9v"), "ffofoo");
  for (const char* text : {"Z", "Zm9vY", "Zm9v!mFy", "Z===", "====", "Zm=v"})
    EXPECT_EQ(base64_decode(text), std::nullopt) << text;
}

TEST(GrpcWebFrame, TakesEveryMessageBackOut) {
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    std::string message(random() % 1000, '\0');
    for (char& c : message) c = static_cast<char>(random());
    const std::string body = data_frame_head(message.size()) + message;
    EXPECT_EQ(message_of_body(body, GrpcWebForm::binary).value(), message);
    EXPECT_EQ(message_of_body(base64_encode(body), GrpcWebForm::text).value(), message);
  }
}

TEST(GrpcWebFrame, WritesTrailersThatAHeaderParserReads) {
  const std::string frame = trailers_frame(5, "no run 7: 50 % \xC3\xA9\r\nx", "\x01\x02");
  EXPECT_EQ(frame.substr(0, 1), "\x80");
  EXPECT_EQ(frame.substr(5),
            "grpc-status: 5\r\ngrpc-message: no run 7: 50 %25 %C3%A9%0D%0Ax\r\n"
            "grpc-status-details-bin: AQI\r\n");
}

TEST(GrpcWebCall, KnowsOurMethodsOnly) {
  EXPECT_TRUE(is_method_path("/driftwise.v1.RunService/GetRun"));
  for (const char* path : {"/driftwise.v1.RunService", "/driftwise.v1.RunService/",
                           "/driftwise.v1./GetRun", "/grpc.health.v1.Health/Check",
                           "/driftwise.v1.RunService/Get/Run", "/driftwise.v1.Run%20/GetRun"})
    EXPECT_FALSE(is_method_path(path)) << path;
}

TEST(GrpcWebCall, ReadsTimeoutsAsTheSpecificationHasThem) {
  const auto timeout = [](const std::string& text) {
    HttpRequest request;
    request.target = "/driftwise.v1.A/B";
    request.headers = {{"grpc-timeout", text}};
    const auto call = grpc_web_call(request);
    return call ? call->timeout : std::nullopt;
  };
  EXPECT_EQ(timeout("2H"), std::chrono::hours(2));
  EXPECT_EQ(timeout("3M"), std::chrono::minutes(3));
  EXPECT_EQ(timeout("100m"), std::chrono::milliseconds(100));
  EXPECT_EQ(timeout("99999999u"), std::chrono::microseconds(99'999'999));
  EXPECT_GT(timeout("99999999H"), std::chrono::hours(1));
  for (const char* text : {"1", "H", "-1S", "123456789S", "1 S", "1s"})
    EXPECT_EQ(timeout(text), std::nullopt) << text;
}

}  // namespace
}  // namespace driftwise::web
