// Length of the texts that clients send: of every field of every rpc.

#include "server/rpc/shared/request_texts.h"

#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>

#include <filesystem>
#include <memory>
#include <set>
#include <span>

#include "driftwise/v1/cell_service.pb.h"
#include "driftwise/v1/data_service.pb.h"
#include "driftwise/v1/run_service.pb.h"
#include "server/rpc/server/guard.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kTooLong(rpc::kMostTextBytes + 1, 'x');

TEST(RequestTexts, AreBoundedInNestedMessagesToo) {
  v1::HomeRequest request;
  request.mutable_answer()->set_override_reason(std::string(rpc::kMostTextBytes, 'x'));
  EXPECT_TRUE(rpc::check_texts(request));
  request.mutable_answer()->set_override_reason(kTooLong);
  const auto refused = rpc::check_texts(request);
  EXPECT_THAT(refused, FailsWith(ErrorCode::invalid_argument, "TOO_LONG"));
  EXPECT_THAT(refused.error().message,
              StartsWith("answer.override_reason: found 16385 bytes, expected at most 16384"));
}

TEST(RequestTexts, AreBoundedTogether) {
  v1::TagRunRequest request;
  for (int i = 0; i < 65; ++i) request.add_remove(std::string(rpc::kMostTextBytes, 'x'));
  EXPECT_THAT(rpc::check_texts(request).error().message, HasSubstr("bytes together"));
  request.mutable_remove()->RemoveLast();
  EXPECT_TRUE(rpc::check_texts(request));
}

TEST(RequestTexts, LeaveWholeFilesToTheirRpc) {
  v1::CreateRunRequest run;
  run.set_trajectory_text(std::string(rpc::kMostTrajectoryBytes, 'x'));
  EXPECT_TRUE(rpc::check_texts(run));
  v1::ImportDatasetRequest dataset;
  dataset.set_csv(std::string(rpc::kMostTextsBytes + 1, 'x'));
  EXPECT_TRUE(rpc::check_texts(dataset));
}

// "answer.override_reason" and so on, as far down as no message is inside itself.
std::vector<std::vector<const FieldDescriptor*>> texts_in(const Descriptor& message,
                                                          std::set<const Descriptor*> above = {}) {
  std::vector<std::vector<const FieldDescriptor*>> out;
  if (!above.insert(&message).second) return out;
  for (int i = 0; i < message.field_count(); ++i) {
    const FieldDescriptor* field = message.field(i);
    if (field->type() == FieldDescriptor::TYPE_STRING) out.push_back({field});
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    for (auto inner : texts_in(*field->message_type(), above)) {
      inner.insert(inner.begin(), field);
      out.push_back(std::move(inner));
    }
  }
  return out;
}

void set_text(Message& message, std::span<const FieldDescriptor* const> path,
              const std::string& text) {
  const FieldDescriptor* field = path.front();
  const auto& reflection = *message.GetReflection();
  if (path.size() > 1)
    set_text(field->is_repeated() ? *reflection.AddMessage(&message, field)
                                  : *reflection.MutableMessage(&message, field),
             path.subspan(1), text);
  else if (field->is_repeated())
    reflection.AddString(&message, field, text);
  else
    reflection.SetString(&message, field, text);
}

class TextsOfEveryRpc : public RpcTest {
 protected:
  Error error_of(const std::string& path, const std::string& request) {
    Call call;
    grpc::CompletionQueue queue;
    grpc::GenericStub stub(channel);
    const auto next = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    const auto stream = stub.PrepareCall(&call, path, &queue);
    stream->StartCall(nullptr);
    grpc::Status status;
    if (next()) {
      const grpc::Slice slice(request);
      stream->WriteLast(grpc::ByteBuffer(&slice, 1), {}, nullptr);
      next();
      grpc::ByteBuffer answer;
      do stream->Read(&answer, nullptr);
      while (next());
    }
    stream->Finish(&status, nullptr);
    next();
    return status.ok() ? Error{} : rpc::to_error(status);
  }
};

TEST_F(TextsOfEveryRpc, AreRefusedWhereTheyAreTooLong) {
  const auto& pool = *google::protobuf::DescriptorPool::generated_pool();
  int fields = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(DRIFTWISE_SOURCE_DIR) +
                                                               "/proto/driftwise/v1")) {
    const auto* proto = pool.FindFileByName("driftwise/v1/" + entry.path().filename().string());
    ASSERT_NE(proto, nullptr) << entry.path() << " is not linked";
    for (int s = 0; s < proto->service_count(); ++s)
      for (int m = 0; m < proto->service(s)->method_count(); ++m) {
        const auto& method = *proto->service(s)->method(m);
        const std::string path = "/" + method.service()->full_name() + "/" + method.name();
        if (path == rpc::kComputeTarget) continue;
        for (const auto& text : texts_in(*method.input_type())) {
          const std::unique_ptr<Message> request(
              google::protobuf::MessageFactory::generated_factory()
                  ->GetPrototype(method.input_type())
                  ->New());
          set_text(*request, text, kTooLong);
          if (rpc::check_texts(*request)) continue;  // a whole file
          const auto error = error_of(path, request->SerializeAsString());
          EXPECT_EQ(error.reason, "TOO_LONG") << path << " " << text.back()->full_name();
          EXPECT_EQ(error.code, ErrorCode::invalid_argument) << path;
          ++fields;
        }
      }
  }
  EXPECT_GT(fields, 100);
}

}  // namespace
}  // namespace driftwise::tests
