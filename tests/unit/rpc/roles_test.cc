// Every rpc with every role, over the daemon's real door: what its option in the proto says is what
// happens. The list of rpcs is the descriptors', so a new one is in it by itself.

#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <sys/stat.h>

#include <filesystem>
#include <map>
#include <mutex>

#include "driftwise/v1/access.pb.h"
#include "driftwise/v1/access_service.grpc.pb.h"
#include "driftwise/v1/cell_service.grpc.pb.h"
#include "driftwise/v1/configuration_service.grpc.pb.h"
#include "driftwise/v1/target_service.grpc.pb.h"
#include "server/access/access.h"
#include "server/formats/cell_file/cell_file_difference.h"
#include "server/rpc/server/guard.h"
#include "tests/support/process.h"
#include "tests/unit/rpc/rpc_fixture.h"

namespace driftwise::tests {
namespace {

using google::protobuf::MethodDescriptor;
using google::protobuf::ServiceDescriptor;
using testing::HasSubstr;

// Services of the package: those of the files that the daemon's own descriptors hang together with.
std::vector<const ServiceDescriptor*> all_services() {
  std::vector<const ServiceDescriptor*> out;
  const auto& pool = *google::protobuf::DescriptorPool::generated_pool();
  for (const auto& entry : std::filesystem::directory_iterator(std::string(DRIFTWISE_SOURCE_DIR) +
                                                               "/proto/driftwise/v1")) {
    const auto* file = pool.FindFileByName("driftwise/v1/" + entry.path().filename().string());
    if (file == nullptr) throw std::runtime_error("not linked: " + entry.path().string());
    for (int i = 0; i < file->service_count(); ++i) out.push_back(file->service(i));
  }
  return out;
}

std::string path_of(const MethodDescriptor& method) {
  return "/" + method.service()->full_name() + "/" + method.name();
}

class Notes final : public access::AccessWitness {
 public:
  void note(access::AccessNote what) override {
    const std::lock_guard lock(mutex_);
    all_.push_back(std::move(what));
  }
  std::vector<access::AccessNote> all() const {
    const std::lock_guard lock(mutex_);
    return all_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<access::AccessNote> all_;
};

class Roles : public testing::Test {
 protected:
  void SetUp() override {
    AccessDescription description;
    description.configured = true;
    description.loopback = LoopbackRule::token;
    auto made = access::Access::open(description, folder.path());
    if (!made) throw std::runtime_error(made.error().message);
    access = std::move(*made);
    access->authoriser().tell(&notes);
    auto opened = rpc::RpcServer::open(cell.services(), "127.0.0.1:0", {}, access.get());
    if (!opened) throw std::runtime_error(opened.error().message);
    server = std::move(*opened);
    channel = open(server->address());
    for (const auto role : access::kRoles)
      tokens[role] =
          access->tokens().create(std::string(to_string(role)), role, "test", 0, {})->text;
  }
  void TearDown() override {
    channel.reset();
    server.reset();
  }
  static std::shared_ptr<grpc::Channel> open(const std::string& address) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  }

  // The call with an empty request, to its end or for long enough to know that it was let in.
  grpc::Status call(const MethodDescriptor& method, const std::string& token,
                    const std::shared_ptr<grpc::Channel>& over,
                    const std::vector<std::pair<std::string, std::string>>& metadata = {}) {
    grpc::ClientContext context;
    const auto limit = std::chrono::milliseconds(method.server_streaming() ? 300 : 20'000);
    context.set_deadline(std::chrono::system_clock::now() + limit);
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    for (const auto& [key, value] : metadata) context.AddMetadata(key, value);
    grpc::CompletionQueue queue;
    grpc::GenericStub stub(over);
    const auto next = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    const auto stream = stub.PrepareCall(&context, path_of(method), &queue);
    stream->StartCall(nullptr);
    grpc::Status status;
    if (next()) {
      const grpc::Slice empty(std::string{});
      stream->WriteLast(grpc::ByteBuffer(&empty, 1), {}, nullptr);
      next();
      grpc::ByteBuffer answer;
      do stream->Read(&answer, nullptr);
      while (next());
    }
    stream->Finish(&status, nullptr);
    next();
    return status;
  }

  tests::TemporaryFolder folder;
  LiveCell cell;
  Notes notes;
  std::unique_ptr<access::Access> access;
  std::unique_ptr<rpc::RpcServer> server;
  std::shared_ptr<grpc::Channel> channel;
  std::map<access::Role, std::string> tokens;
};

TEST_F(Roles, AreWhatEachRpcDeclares) {
  const auto passing = cell.passing();  // a stop asks the axis twice
  int rpcs = 0, allowed = 0, refused = 0;
  for (const auto* service : all_services())
    for (int i = 0; i < service->method_count(); ++i, ++rpcs) {
      const auto& method = *service->method(i);
      ASSERT_TRUE(method.options().HasExtension(v1::role)) << method.full_name();
      const auto needed = static_cast<access::Role>(method.options().GetExtension(v1::role));
      for (const auto role : access::kRoles) {
        const auto status = call(method, tokens[role], channel);
        const auto error = rpc::to_error(status);
        const std::string what = method.full_name() + " as " + std::string(to_string(role)) + ": " +
                                 error.reason + " " + status.error_message();
        if (includes(role, needed)) {
          ++allowed;
          EXPECT_NE(error.reason, "NEEDS_ROLE") << what;
          EXPECT_NE(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << what;
          EXPECT_NE(status.error_code(), grpc::StatusCode::UNIMPLEMENTED) << what;
        } else {
          ++refused;
          EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED) << what;
          EXPECT_EQ(error.reason, "NEEDS_ROLE") << what;
          EXPECT_THAT(error.message, HasSubstr("needs the role " + std::string(to_string(needed))));
        }
      }
      const auto nobody = call(method, "", channel);
      EXPECT_EQ(nobody.error_code(), grpc::StatusCode::UNAUTHENTICATED) << method.full_name();
      EXPECT_EQ(rpc::to_error(nobody).reason, "NO_IDENTITY") << method.full_name();
      ++refused;
    }
  EXPECT_GT(rpcs, 70);
  std::printf("%d rpcs, %d calls allowed, %d refused\n", rpcs, allowed, refused);
}

TEST_F(Roles, LetWhoeverMayLookStop) {
  const auto passing = cell.passing();
  for (const auto role : access::kRoles) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + tokens[role]);
    v1::StopAllResponse response;
    const auto status = v1::CellService::Stub(channel).StopAll(&context, {}, &response);
    EXPECT_TRUE(status.ok()) << to_string(role) << ": " << status.error_message();
  }
  const auto stop = cell.last_event("stop");
  ASSERT_TRUE(stop);
  EXPECT_TRUE(access::role_from(stop->who)) << stop->who;
  EXPECT_THAT(stop->from, HasSubstr("(token "));
}

TEST_F(Roles, AreNotReadFromWhatAClientSaysOfItself) {
  const auto& home = *google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(
      "driftwise.v1.CellService.Home");
  const access::Identity eve{"eve", access::Role::admin, access::Proof::local_socket, "", "unix:"};
  const std::string vouched = access->authoriser().vouch(eve);
  for (const auto& metadata : std::vector<std::vector<std::pair<std::string, std::string>>>{
           {{"driftwise-operator", "admin"}},
           {{"driftwise-peer", "unix:"}},
           {{access::Authoriser::kVouchedKey, vouched}},
           {{"x-forwarded-for", "127.0.0.1"}},
           {{"authorization", "Basic YWRtaW46YWRtaW4="}},
           {{"authorization", "Bearer"}},
           {{"authorization", "Bearer "}},
           {{"authorization", "Bearer " + tokens[access::Role::admin] + "x"}}}) {
    const auto status = call(home, "", channel, metadata);
    EXPECT_TRUE(status.error_code() == grpc::StatusCode::UNAUTHENTICATED ||
                status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED)
        << metadata[0].first << ": " << status.error_message();
  }
}

TEST_F(Roles, OfTheLocalSocketAndItsTokenFileAreAdmin) {
  struct stat about {};
  ASSERT_EQ(::stat(server->socket_path().c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  ASSERT_EQ(::stat(access->token_file().c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  std::string token = read_file(access->token_file());
  token.pop_back();
  const auto ask = [](const std::shared_ptr<grpc::Channel>& over, const std::string& bearer) {
    grpc::ClientContext context;
    if (!bearer.empty()) context.AddMetadata("authorization", "Bearer " + bearer);
    v1::GetIdentityResponse response;
    const auto status = v1::AccessService::Stub(over).GetIdentity(&context, {}, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.identity();
  };
  const auto by_socket = ask(open("unix:" + server->socket_path()), "");
  EXPECT_EQ(by_socket.role(), v1::ROLE_ADMIN);
  EXPECT_EQ(by_socket.proof(), "local socket");
  EXPECT_EQ(by_socket.from(), "unix:");
  const auto by_token = ask(channel, token);
  EXPECT_EQ(by_token.role(), v1::ROLE_ADMIN);
  EXPECT_EQ(by_token.credential(), "local");
}

TEST_F(Roles, BelowAdminReadTheCellFileWithoutItsSecrets) {
  const std::string text =
      "# hush1\n[[notify]]\nname = \"duty\"\nwebhook = \"https://alerts.example/hush2\"\n";
  cell.on_store([&](Store& store) {
    ConfigurationStart start;
    start.hash = "aaaa";
    start.changes_json = formats::write_changes_json(
        {{"notify duty", "webhook", "", "https://alerts.example/hush2", false, {}}});
    EXPECT_TRUE(store.configurations().begin(start, text));
  });
  for (const auto role : access::kRoles) {
    v1::ConfigurationService::Stub stub(channel);
    grpc::ClientContext reading, listing;
    for (auto* context : {&reading, &listing})
      context->AddMetadata("authorization", "Bearer " + tokens[role]);
    v1::GetConfigurationRequest request;
    request.set_hash("aaaa");
    request.set_compare_hash("aaaa");
    v1::GetConfigurationResponse read;
    const auto status = stub.GetConfiguration(&reading, request, &read);
    ASSERT_TRUE(status.ok()) << status.error_message();
    if (role == access::Role::admin)
      EXPECT_EQ(read.text(), text);
    else
      EXPECT_THAT(read.text(), testing::AllOf(HasSubstr("https://alerts.example/[removed]"),
                                              testing::Not(HasSubstr("hush"))));
    v1::ListConfigurationsResponse list;
    ASSERT_TRUE(stub.ListConfigurations(&listing, {}, &list).ok());
    ASSERT_EQ(list.starts(0).changes_size(), 1);
    EXPECT_EQ(list.starts(0).changes(0).after(), "https://alerts.example/[removed]");
  }
}

TEST_F(Roles, AreAskedBeforeTheLengthOfTexts) {
  const auto reason_for = [&](const std::string& token) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::RevokeTokenRequest request;
    request.set_id(std::string(20'000, 'x'));
    v1::RevokeTokenResponse response;
    return rpc::to_error(v1::AccessService::Stub(channel).RevokeToken(&context, request, &response))
        .reason;
  };
  EXPECT_EQ(reason_for(tokens[access::Role::viewer]), "NEEDS_ROLE");
  EXPECT_EQ(reason_for("dwt_nobody"), "BAD_TOKEN");
  EXPECT_EQ(reason_for(tokens[access::Role::admin]), "TOO_LONG");
}

TEST_F(Roles, EndWithTheTokenForCallsThatBeginLater) {
  const auto socket = open("unix:" + server->socket_path());
  const auto made = [&] {
    grpc::ClientContext context;
    v1::CreateTokenRequest request;
    request.set_name("press");
    request.set_role(v1::ROLE_VIEWER);
    v1::CreateTokenResponse response;
    EXPECT_TRUE(v1::AccessService::Stub(socket).CreateToken(&context, request, &response).ok());
    return response;
  }();
  const auto status_with = [&](const std::string& token) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::GetStatusResponse response;
    return v1::CellService::Stub(channel).GetStatus(&context, {}, &response).error_code();
  };
  EXPECT_EQ(status_with(made.text()), grpc::StatusCode::OK);
  {
    grpc::ClientContext context;
    v1::RevokeTokenRequest request;
    request.set_id(made.token().id());
    v1::RevokeTokenResponse response;
    EXPECT_TRUE(v1::AccessService::Stub(socket).RevokeToken(&context, request, &response).ok());
  }
  EXPECT_EQ(status_with(made.text()), grpc::StatusCode::UNAUTHENTICATED);
  std::string told;
  for (const auto& note : notes.all()) {
    told += to_event(note.kind) + " ";
    const bool by_nobody = note.kind == access::AccessNote::Kind::wrong_try;
    EXPECT_EQ(note.proof, by_nobody ? "" : "local socket");
  }
  EXPECT_EQ(told, "access.token_made access.token_revoked access.wrong_try ");
}

TEST_F(Roles, OfTheGatewayAreThoseItVouchesFor) {
  const auto inside = server->in_process_channel();
  const auto& home = *google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(
      "driftwise.v1.CellService.Home");
  EXPECT_EQ(call(home, "", inside).error_code(), grpc::StatusCode::UNAUTHENTICATED);
  const access::Identity viewer{"eve", access::Role::viewer, access::Proof::page_session, "s1",
                                "ipv4:10.0.0.9:1"};
  const auto status = call(home, "", inside,
                           {{access::Authoriser::kVouchedKey, access->authoriser().vouch(viewer)}});
  EXPECT_EQ(rpc::to_error(status).reason, "NEEDS_ROLE");
  EXPECT_THAT(status.error_message(),
              HasSubstr("eve (page session s1, viewer, from ipv4:10.0.0.9"));
}

TEST_F(Roles, AreNotAskedForWhatIsNotThere) {
  for (int i = 0; i < 20; ++i) {
    grpc::ClientContext context;
    grpc::CompletionQueue queue;
    grpc::GenericStub stub(channel);
    const grpc::Slice empty(std::string{});
    const auto unknown = stub.PrepareUnaryCall(&context, "/driftwise.v1.CellService/NoSuchRpc",
                                               grpc::ByteBuffer(&empty, 1), &queue);
    unknown->StartCall();
    grpc::ByteBuffer answer;
    grpc::Status status;
    unknown->Finish(&answer, &status, nullptr);
    void* tag = nullptr;
    bool ok = false;
    queue.Next(&tag, &ok);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNIMPLEMENTED);
  }
}

TEST(RoleTable, RefusesAnRpcThatDeclaresNone) {
  google::protobuf::DescriptorPool pool;
  google::protobuf::FileDescriptorProto file;
  file.set_name("open.proto");
  file.set_package("test");
  file.add_message_type()->set_name("Empty");
  auto& service = *file.add_service();
  service.set_name("OpenService");
  auto& method = *service.add_method();
  method.set_name("Ask");
  method.set_input_type(".test.Empty");
  method.set_output_type(".test.Empty");
  ASSERT_NE(pool.BuildFile(file), nullptr);
  rpc::RoleTable table;
  const auto added = rpc::add_roles(*pool.FindServiceByName("test.OpenService"), table);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().reason, "NO_ROLE");
  EXPECT_THAT(added.error().message, HasSubstr("test.OpenService.Ask"));
}

}  // namespace
}  // namespace driftwise::tests
