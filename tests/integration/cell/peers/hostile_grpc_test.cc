// What strangers may send to the gRPC doors before anybody has let them in: broken TLS records,
// HTTP/2 frames and headers, tokens, from a seeded grammar. The daemon stays, its memory stays
// within bounds, and its own client is served.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <netinet/in.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <random>

#include "driftwise/v1/cell_service.grpc.pb.h"
#include "tests/integration/cell/cell_at_work.h"

namespace driftwise::tests {
namespace {

constexpr unsigned kSeed = 20110722;
constexpr std::size_t kMostGrowthBytes = std::size_t{150} << 20;

std::size_t resident_bytes_of(pid_t pid) {
  std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
  std::size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

// Sends the bytes, takes what comes within a moment, goes. How it ended says nothing.
void throw_at(int port, const std::string& bytes) {
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &peer.sin_addr);
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::connect(socket, reinterpret_cast<sockaddr*>(&peer), sizeof peer) == 0) {
    static_cast<void>(!::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT));
    pollfd there{socket, POLLIN, 0};
    char answer[4096];
    if (::poll(&there, 1, 2) > 0)
      static_cast<void>(!::recv(socket, answer, sizeof answer, MSG_DONTWAIT));
  }
  ::close(socket);
}

// The first words of a real client, as OpenSSL says them.
std::string client_hello() {
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  SSL* client = SSL_new(context);
  BIO* in = BIO_new(BIO_s_mem());
  BIO* out = BIO_new(BIO_s_mem());
  SSL_set_bio(client, in, out);
  SSL_connect(client);
  char* data = nullptr;
  const long size = BIO_get_mem_data(out, &data);
  std::string hello(data, static_cast<std::size_t>(size));
  SSL_free(client);
  SSL_CTX_free(context);
  return hello;
}

class Grammar {
 public:
  std::string bytes(std::size_t most) {
    std::string out(random_() % (most + 1), '\0');
    for (char& c : out) c = static_cast<char>(random_());
    return out;
  }
  std::string broken(std::string text) {
    for (std::size_t changes = 1 + random_() % 6; changes > 0 && !text.empty(); --changes) {
      const std::size_t at = random_() % text.size();
      switch (random_() % 4) {
        case 0:
          text[at] = static_cast<char>(random_());
          break;
        case 1:
          text.erase(at, 1 + random_() % 8);
          break;
        case 2:
          text.insert(at, bytes(16));
          break;
        default:
          text.resize(at);
      }
    }
    return text;
  }
  // A record of TLS with a length that is right, too long or too short.
  std::string record() {
    const std::string body = bytes(300);
    const std::size_t said = random_() % 3 == 0 ? random_() % 65'536 : body.size();
    std::string out;
    out += static_cast<char>(20 + random_() % 6);
    out += '\3';
    out += static_cast<char>(random_() % 5);
    out += static_cast<char>(said >> 8U & 255U);
    out += static_cast<char>(said & 255U);
    return out + body;
  }
  std::string frame() {
    const std::string body = bytes(200);
    const std::size_t said = random_() % 3 == 0 ? random_() % 16'777'216 : body.size();
    std::string out;
    for (const unsigned shift : {16U, 8U, 0U}) out += static_cast<char>(said >> shift & 255U);
    out += static_cast<char>(random_() % 12);
    out += static_cast<char>(random_());
    for (int i = 0; i < 4; ++i) out += static_cast<char>(random_() % 3 ? 0 : random_());
    return out + body;
  }
  std::string literal(const std::string& name, const std::string& value) {
    return std::string(1, '\0') + static_cast<char>(name.size() & 127U) + name +
           static_cast<char>(value.size() & 127U) + value;
  }
  // A call whose headers are a call's, but for one that is not.
  std::string call() {
    static const std::vector<std::string> kPaths = {"/driftwise.v1.CellService/Home",
                                                    "/driftwise.v1.CellService/",
                                                    "/",
                                                    "",
                                                    "/driftwise.v1.NoService/NoRpc",
                                                    "driftwise.v1.CellService/Home",
                                                    "/driftwise.v1.AccessService/CreateToken",
                                                    "/driftwise.v1.CellService/GetStatus\n"};
    std::string headers =
        literal(":method", random_() % 4 ? "POST" : "GET") + literal(":scheme", "http") +
        literal(":path", kPaths[random_() % kPaths.size()]) + literal(":authority", "localhost") +
        literal("content-type", "application/grpc") + literal("te", "trailers") +
        literal("authorization", token()) + literal("driftwise-identity-bin", bytes(60)) +
        literal("driftwise-operator", bytes(60));
    if (random_() % 2) headers = broken(headers);
    std::string out;
    for (const unsigned shift : {16U, 8U, 0U})
      out += static_cast<char>(headers.size() >> shift & 255U);
    out += std::string("\1\5\0\0\0\1", 6);
    return out + headers;
  }
  std::string connection() {
    std::string out("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
    out += std::string("\0\0\0\4\0\0\0\0\0", 9);
    if (random_() % 8 == 0) out = broken(out);
    for (std::size_t i = random_() % 5; i > 0; --i) out += random_() % 2 ? frame() : call();
    return out;
  }
  std::string token() {
    static constexpr char kText[] = "abcdefghijklmnopqrstuvwxyz0123456789-_ABC";
    std::string out = random_() % 4 ? "Bearer dwt_" : "Bearer ";
    for (std::size_t i = random_() % 70; i > 0; --i) out += kText[random_() % (sizeof kText - 1)];
    return out;
  }
  std::string text_token() {
    std::string out = "dwt_";
    for (int i = 0; i < 8; ++i) out += static_cast<char>('a' + random_() % 26);
    out += '_';
    for (int i = 0; i < 43; ++i) out += static_cast<char>('A' + random_() % 26);
    if (random_() % 3 == 0) out.resize(random_() % out.size());
    return "Bearer " + out;
  }

 private:
  std::mt19937 random_{kSeed};
};

int port_of(const std::string& address) {
  return std::stoi(address.substr(address.rfind(':') + 1));
}

TEST(HostileClients, BringNeitherTheDaemonDownNorItsMemoryUp) {
  CellAtWork cell;
  const auto here = [&](std::vector<std::string> arguments) {
    std::vector<std::string> command = {"/usr/bin/env", "-C", cell.folder(),
                                        std::string(DRIFTWISE_BIN_DIR) + "/driftwise"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_process(command);
  };
  ASSERT_EQ(here({"cert", "init"}).code, 0);
  write_file(cell.folder() + "/cell.toml",
             read_file(cell.folder() + "/cell.toml") +
                 "\n[access]\nlisten = \"127.0.0.1:0\"\ncertificate = \"tls/server.pem\"\n"
                 "key = \"tls/server.key\"\nauthority = \"tls/authority.pem\"\n");
  cell.start_daemon();
  const auto notice = nlohmann::json::parse(read_file(cell.folder() + "/driftwised.json"));
  const int plain = port_of(notice.at("grpc")), tls = port_of(notice.at("grpc_tls"));
  const pid_t pid = cell.daemon().pid();
  const std::string hello = client_hello();
  ASSERT_GT(hello.size(), 100U);
  Grammar grammar;
  for (int i = 0; i < 50; ++i) {  // what a first meeting costs is no growth
    throw_at(tls, grammar.record());
    throw_at(plain, grammar.connection());
  }
  const std::size_t before = resident_bytes_of(pid);
  std::map<std::string, int> counts;
  for (int i = 0; i < 600; ++i) {
    throw_at(tls, grammar.bytes(600)), ++counts["random bytes to TLS"];
    throw_at(tls, grammar.record()), ++counts["TLS records"];
    throw_at(tls, grammar.broken(hello)), ++counts["broken ClientHellos"];
    throw_at(tls, hello + grammar.record()), ++counts["ClientHello, then records"];
    throw_at(tls, grammar.connection()), ++counts["plain HTTP/2 to TLS"];
    throw_at(plain, grammar.connection()), ++counts["HTTP/2 frames and headers"];
    throw_at(plain, hello), ++counts["TLS to the plain door"];
  }
  std::map<grpc::StatusCode, int> answers;
  grpc::SslCredentialsOptions trusting;
  trusting.pem_root_certs = read_file(cell.folder() + "/tls/authority.pem");
  const auto channel =
      grpc::CreateChannel("127.0.0.1:" + std::to_string(tls), grpc::SslCredentials(trusting));
  for (int i = 0; i < 400; ++i, ++counts["tokens over TLS"]) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(20));
    context.AddMetadata("authorization", grammar.text_token());
    v1::GetStatusResponse response;
    const auto status = v1::CellService::Stub(channel).GetStatus(&context, {}, &response);
    ++answers[status.error_code()];
    EXPECT_EQ(response.ByteSizeLong(), 0U);
  }
  EXPECT_EQ(
      answers[grpc::StatusCode::UNAUTHENTICATED] + answers[grpc::StatusCode::RESOURCE_EXHAUSTED],
      400);
  EXPECT_GT(answers[grpc::StatusCode::RESOURCE_EXHAUSTED], 0) << "they were slowed";
  const std::size_t after = resident_bytes_of(pid);
  for (const auto& [what, count] : counts) std::printf("%5d %s\n", count, what.c_str());
  std::printf("resident memory %.1f MiB before, %.1f MiB after\n",
              static_cast<double>(before) / (1 << 20), static_cast<double>(after) / (1 << 20));
  EXPECT_LT(after, before + kMostGrowthBytes);
  EXPECT_TRUE(cell.daemon().running());
  const auto status = here({"status"});
  EXPECT_EQ(status.code, 0) << status.err;
  EXPECT_EQ(cell.stop_daemon(), 0);
}

}  // namespace
}  // namespace driftwise::tests
