#include "server/rpc/shared/error_mapping.h"

#include <gtest/gtest.h>

#include "driftwise/v1/error_detail.pb.h"

namespace driftwise::rpc {
namespace {

constexpr ErrorCode kAll[] = {ErrorCode::invalid_argument,
                              ErrorCode::not_found,
                              ErrorCode::already_exists,
                              ErrorCode::failed_precondition,
                              ErrorCode::aborted,
                              ErrorCode::out_of_range,
                              ErrorCode::resource_exhausted,
                              ErrorCode::unavailable,
                              ErrorCode::deadline_exceeded,
                              ErrorCode::data_loss,
                              ErrorCode::permission_denied,
                              ErrorCode::cancelled,
                              ErrorCode::internal};

TEST(ErrorMapping, TakesEveryCodeThereAndBack) {
  for (const ErrorCode code : kAll) {
    const grpc::Status status = to_status({code, "SOME_REASON", "what to do"});
    EXPECT_FALSE(status.ok());
    const Error back = to_error(status);
    EXPECT_EQ(back.code, code) << to_string(code);
    EXPECT_EQ(back.reason, "SOME_REASON");
    EXPECT_EQ(back.message, "what to do");
  }
}

// The numbers of google.rpc.Code, from the gRPC documentation (statuscodes.md).
TEST(ErrorMapping, UsesTheCodesOfTheSameName) {
  EXPECT_EQ(status_code(ErrorCode::cancelled), 1);
  EXPECT_EQ(status_code(ErrorCode::invalid_argument), 3);
  EXPECT_EQ(status_code(ErrorCode::not_found), 5);
  EXPECT_EQ(status_code(ErrorCode::permission_denied), 7);
  EXPECT_EQ(status_code(ErrorCode::failed_precondition), 9);
  EXPECT_EQ(status_code(ErrorCode::unavailable), 14);
  EXPECT_EQ(status_code(ErrorCode::data_loss), 15);
}

// google.rpc.Status by hand: field 1 varint code, 2 message, 3 Any {1 type_url, 2 value}.
TEST(ErrorMapping, PacksTheBytesOfGoogleRpcStatus) {
  const std::string details = to_status({ErrorCode::not_found, "R", "m"}).error_details();
  v1::ErrorDetail detail;
  detail.set_reason("R");
  detail.set_message("m");
  const std::string url = "type.googleapis.com/driftwise.v1.ErrorDetail",
                    value = detail.SerializeAsString();
  const std::string any = std::string("\x0a") + static_cast<char>(url.size()) + url + "\x12" +
                          static_cast<char>(value.size()) + value;
  EXPECT_EQ(details, std::string("\x08\x05\x12\x01m\x1a") + static_cast<char>(any.size()) + any);
}

TEST(ErrorMapping, CutsAMessageThatWouldNotFitAHeader) {
  const grpc::Status status =
      to_status({ErrorCode::invalid_argument, "LONG", std::string(100'000, 'x')});
  EXPECT_LT(status.error_message().size(), 3000U);
  EXPECT_TRUE(status.error_message().ends_with(" ..."));
  EXPECT_EQ(to_error(status).reason, "LONG");
}

TEST(ErrorMapping, ReplacesBytesThatAreNoText) {
  const grpc::Status status =
      to_status({ErrorCode::data_loss, "BAD_REPLY", "found '\xff\xc0\x80ok\xe2\x82\xac'"});
  EXPECT_EQ(to_error(status).message, "found '???ok\xe2\x82\xac'");
}

TEST(ErrorMapping, AForeignStatusHasNoReason) {
  const Error error = to_error({grpc::StatusCode::UNIMPLEMENTED, "no such method"});
  EXPECT_EQ(error.code, ErrorCode::internal);
  EXPECT_EQ(error.reason, "");
}

}  // namespace
}  // namespace driftwise::rpc
