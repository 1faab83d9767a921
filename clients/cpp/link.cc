#include "clients/cpp/link.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "clients/cpp/failure.h"

namespace driftwise::client {
namespace {

// Empty for no path.
std::string read_pem(const std::filesystem::path& path, std::optional<Failure>& trouble) {
  if (path.empty()) return {};
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if ((!file || text.empty()) && !trouble)
    trouble =
        Failure{"BAD_CREDENTIALS",
                path.string() + ": cannot be read, expected a PEM file that this user may read"};
  return text;
}

std::shared_ptr<grpc::ChannelCredentials> credentials_of(const Credentials& given,
                                                         std::optional<Failure>& trouble) {
  if (given.authority.empty()) {
    if (!given.certificate.empty() || !given.key.empty())
      trouble = Failure{"BAD_CREDENTIALS",
                        "a client certificate is shown over TLS only: name the authority that "
                        "signed the daemon's certificate"};
    return grpc::InsecureChannelCredentials();
  }
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = read_pem(given.authority, trouble);
  options.pem_cert_chain = read_pem(given.certificate, trouble);
  options.pem_private_key = read_pem(given.key, trouble);
  if (options.pem_cert_chain.empty() != options.pem_private_key.empty() && !trouble)
    trouble = Failure{"BAD_CREDENTIALS", "certificate and key belong together: name both or none"};
  return grpc::SslCredentials(options);
}

// A token as files hold it, without the line's end. gRPC ends the process over a header that holds
// anything else than printable ASCII.
std::string bearer_of(const std::string& token, std::optional<Failure>& trouble) {
  constexpr const char* kBlanks = " \t\r\n";
  const auto first = token.find_first_not_of(kBlanks);
  if (first == std::string::npos) return {};
  const auto text = token.substr(first, token.find_last_not_of(kBlanks) - first + 1);
  const auto bad =
      std::find_if(text.begin(), text.end(), [](char c) { return c <= ' ' || c > '~'; });
  if (bad == text.end()) return "Bearer " + text;
  if (!trouble)
    trouble = Failure{"BAD_CREDENTIALS",
                      "token: character " + std::to_string(bad - text.begin() + 1) + " of " +
                          std::to_string(text.size()) +
                          " is a blank or no printable ASCII, expected one word as `driftwise "
                          "token create` made it"};
  return {};
}

std::shared_ptr<grpc::Channel> open_channel(
    const std::string& address, const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
  grpc::ChannelArguments arguments;
  // The daemon stands on this computer or in its network: never through a proxy.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // gRPC's own pause between two attempts grows to two minutes; a controller cannot wait so long.
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1000);
  // A daemon whose computer or cable fell silent is lost after this. It pings by itself every 60 s,
  // so that this ping goes to a silent one only and its ping policy counts none.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 90'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20'000);
  return grpc::CreateCustomChannel(address, credentials, arguments);
}

}  // namespace

Link::Link(std::string to, std::string who, const Credentials& credentials)
    : address(std::move(to)),
      operator_name(std::move(who)),
      channel(open_channel(address, credentials_of(credentials, trouble))),
      reconnection_(std::make_unique<Reconnection>(channel)) {
  bearer = bearer_of(credentials.token, trouble);
}

Failure Link::failure_of(const grpc::Status& status) const {
  auto failure = client::failure_of(status, address);
  if (failure.reason == "NO_DAEMON") reconnection_->lost();
  return failure;
}

void Link::sign(grpc::ClientContext& context) const {
  if (!bearer.empty()) context.AddMetadata("authorization", bearer);
  if (operator_name.empty()) return;
  const bool ascii = std::all_of(operator_name.begin(), operator_name.end(),
                                 [](char c) { return c >= 0x20 && c < 0x7F; });
  context.AddMetadata(ascii ? "driftwise-operator" : "driftwise-operator-bin", operator_name);
}

}  // namespace driftwise::client
