#include "clients/cli/core/way.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "server/tls/own_certificate.h"

namespace driftwise::cli {
namespace {

// What gRPC would try for ever, or look up as a name: "localhost", "127.0.0.1:70000". Its own forms
// (unix:/path, dns:///name) pass.
std::string checked_address(const std::string& address, const char* from) {
  if (address.starts_with("unix:/")) return address;
  const auto colon = address.rfind(':');
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  const bool number = !port.empty() && port.find_first_not_of("0123456789") == std::string::npos;
  const bool beyond = number && (port.size() > 5 || std::stoi(port) > 65535 || std::stoi(port) < 1);
  if (colon == std::string::npos || port.empty() || beyond)
    throw Failure{ExitCode::usage, "usage", "BAD_ADDRESS",
                  std::string(from) + ": found '" + address +
                      "', expected host:port such as 127.0.0.1:50051"};
  return address;
}

struct Notice {  // driftwised.json
  std::string grpc, socket, token_file;
};

std::optional<Notice> read_notice(const Console& console) {
  const auto path = std::filesystem::path(console.working_folder) / "driftwised.json";
  std::ifstream file(path);
  if (!file) return std::nullopt;
  const auto json = nlohmann::json::parse(file, nullptr, false);
  const auto text = [&json](const char* key) {
    return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : "";
  };
  if (!json.is_object() || text("grpc").empty())
    throw Failure{
        ExitCode::bad_input, "invalid_argument", "BAD_NOTICE",
        path.string() +
            ": expected a JSON object with the daemon's address under \"grpc\"; remove the file or "
            "give --server host:port"};
  return Notice{text("grpc"), text("socket"), text("token_file")};
}

struct Given {
  std::string value;
  const char* from;
};

Given given(const std::string& flag, const char* flag_name, const Console& console,
            const char* variable) {
  if (!flag.empty()) return {flag, flag_name};
  return {console.variable(variable), variable};
}

std::string whole_file(const Given& given) {
  if (given.value.empty()) return {};
  std::error_code ignored;
  std::ifstream file(given.value, std::ios::binary);
  if (!file || std::filesystem::is_directory(given.value, ignored))
    throw Failure{ExitCode::bad_input, "not_found", "NO_FILE",
                  std::string(given.from) + ": cannot read " + given.value +
                      (file ? "" : std::string(": ") + std::strerror(errno))};
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string pem_file(const Given& given, const char* what) {
  std::string text = whole_file(given);
  if (!given.value.empty() && text.find("-----BEGIN ") == std::string::npos)
    throw Failure{
        ExitCode::bad_input, "invalid_argument", "BAD_CERTIFICATE",
        std::string(given.from) + ": " + given.value + " holds no " + what + " in PEM form"};
  return text;
}

std::string token_in(const Given& given) {
  std::string text = whole_file(given);
  text.erase(0, text.find_first_not_of(" \t\r\n"));
  text.erase(text.find_last_not_of(" \t\r\n") + 1);
  if (!given.value.empty() &&
      (!text.starts_with("dwt_") || text.find_first_of(" \t\r\n") != std::string::npos))
    throw Failure{ExitCode::bad_input, "invalid_argument", "BAD_TOKEN",
                  std::string(given.from) + ": " + given.value +
                      " holds no token, expected one line that begins with dwt_"};
  return text;
}

bool may_use(const std::string& path, int how) {
  return !path.empty() && ::access(path.c_str(), how) == 0;
}

}  // namespace

Way find_way(const WayOptions& options, const Console& console) {
  const auto server = given(options.server, "--server", console, "DRIFTWISE_SERVER");
  const auto authority = given(options.tls_ca, "--tls-ca", console, "DRIFTWISE_TLS_CA");
  const auto certificate = given(options.tls_cert, "--tls-cert", console, "DRIFTWISE_TLS_CERT");
  const auto key = given(options.tls_key, "--tls-key", console, "DRIFTWISE_TLS_KEY");
  const auto token = given(options.token_file, "--token-file", console, "DRIFTWISE_TOKEN_FILE");
  Way way;
  way.authority_pem = pem_file(authority, "certificate");
  way.certificate_pem = pem_file(certificate, "certificate");
  way.key_pem = pem_file(key, "key");
  way.token = token_in(token);
  if (way.certificate_pem.empty() != way.key_pem.empty())
    throw Failure{ExitCode::usage, "usage", "HALF_A_CERTIFICATE",
                  "--tls-cert and --tls-key belong together: give both or none"};
  if (!way.certificate_pem.empty() && !way.tls())
    throw Failure{ExitCode::usage, "usage", "NO_AUTHORITY",
                  "--tls-cert without --tls-ca: give the certificate of the authority that signed "
                  "the daemon's (authority.pem of 'driftwise cert init')"};
  if (!way.certificate_pem.empty())
    if (const auto pair = tls::check_pair(way.certificate_pem, way.key_pem); !pair)
      throw Failure{ExitCode::bad_input, "invalid_argument", pair.error().reason,
                    "--tls-cert and --tls-key: " + pair.error().message};
  const auto notice = read_notice(console);
  const bool local = !way.tls() && way.token.empty();
  if (!server.value.empty()) {
    way.address = checked_address(server.value, server.from);
  } else if (notice && local && may_use(notice->socket, R_OK | W_OK)) {
    way.address = "unix:" + notice->socket;
    way.cell_folder = console.working_folder;
    return way;
  } else {
    way.address = notice ? notice->grpc : "127.0.0.1:50051";
  }
  if (notice && (way.address == notice->grpc || way.address == "unix:" + notice->socket))
    way.cell_folder = console.working_folder;
  if (notice && local && way.address == notice->grpc && may_use(notice->token_file, R_OK))
    way.token = token_in({notice->token_file, "driftwised.json"});
  return way;
}

}  // namespace driftwise::cli
