#include "server/tls/tls_material.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509err.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>

#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::tls {
namespace {

using boost::system::error_code;
namespace ssl = boost::asio::ssl;

tl::unexpected<Error> bad_file(const char* what, const std::string& path, const std::string& why) {
  return fail(ErrorCode::failed_precondition, reasons::kBadCertificate,
              std::string("[access] ") + what + ": " + path + ": " + why +
                  "; expected a PEM file (make one with driftwise cert init)");
}

// The one protocol that this door speaks, as ALPN writes it: a byte of length before the name.
// argument: the owning TlsMaterial's protocol, which outlives the context's handshakes.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* length,
                    const unsigned char* offered, unsigned int size, void* argument) {
  const auto& wanted = *static_cast<const std::string*>(argument);
  for (unsigned int at = 0; at < size; at += 1U + offered[at]) {
    const unsigned int bytes = offered[at];
    if (at + 1 + bytes > size) break;
    if (std::string_view(reinterpret_cast<const char*>(offered) + at + 1, bytes) != wanted)
      continue;
    *chosen = offered + at + 1;
    *length = offered[at];
    return SSL_TLSEXT_ERR_OK;
  }
  return SSL_TLSEXT_ERR_NOACK;
}

}  // namespace

TlsMaterial::TlsMaterial(TlsFiles files, ClientCertificate clients, std::string protocol)
    : files_(std::move(files)), clients_(clients), protocol_(std::move(protocol)) {}

Result<std::unique_ptr<TlsMaterial>> TlsMaterial::open(TlsFiles files, ClientCertificate clients,
                                                       std::string protocol) {
  std::unique_ptr<TlsMaterial> out(new TlsMaterial(std::move(files), clients, std::move(protocol)));
  out->read_stamps_ = out->stamps();
  DRIFTWISE_TRY(out->context_, out->read());
  out->looked_ = std::chrono::steady_clock::now();
  return out;
}

std::shared_ptr<TlsMaterial::Context> TlsMaterial::context() {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_ < kLook) return context_;
  looked_ = now;
  const auto present = stamps();
  if (present == read_stamps_) {
    problem_.reset();
    return context_;
  }
  if (problem_ && present == failed_stamps_) return context_;
  if (auto fresh = read()) {
    context_ = std::move(*fresh);
    read_stamps_ = present;
    problem_.reset();
    spdlog::info("TLS: {} was read anew", files_.certificate);
  } else {
    failed_stamps_ = present;
    problem_ = fresh.error().message + "; the certificate of before serves on";
    spdlog::warn("{}", *problem_);
  }
  return context_;
}

TlsMaterial::Stamps TlsMaterial::stamps() const {
  Stamps out;
  const std::array<const std::string*, 3> paths = {&files_.certificate, &files_.key,
                                                   &files_.authority};
  for (std::size_t i = 0; i < paths.size(); ++i) {
    struct stat found {};
    if (paths[i]->empty() || ::stat(paths[i]->c_str(), &found) != 0) continue;
    out[i] = {std::int64_t{found.st_mtim.tv_sec} * 1'000'000'000 + found.st_mtim.tv_nsec,
              found.st_ino, static_cast<std::uint64_t>(found.st_size)};
  }
  return out;
}

Result<std::shared_ptr<TlsMaterial::Context>> TlsMaterial::read() const {
  auto out = std::make_shared<Context>(Context::tls_server);
  SSL_CTX* raw = out->native_handle();
  SSL_CTX_set_min_proto_version(raw, TLS1_2_VERSION);
  SSL_CTX_set_options(raw, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_TICKET | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_session_cache_mode(raw, SSL_SESS_CACHE_OFF);
  error_code failed;
  // Without it OpenSSL would ask the terminal for the password of a locked key.
  out->set_password_callback([](std::size_t, auto) { return std::string(); }, failed);
  out->use_certificate_chain_file(files_.certificate, failed);
  if (failed) return bad_file("certificate", files_.certificate, failed.message());
  out->use_private_key_file(files_.key, Context::pem, failed);
  const bool other =
      ERR_GET_REASON(static_cast<unsigned long>(failed.value())) == X509_R_KEY_VALUES_MISMATCH;
  if (failed)
    return bad_file("key", files_.key,
                    other ? "it does not belong to " + files_.certificate : failed.message());
  if (clients_ == ClientCertificate::accepted && !files_.authority.empty()) {
    out->load_verify_file(files_.authority, failed);
    if (failed) return bad_file("authority", files_.authority, failed.message());
    SSL_CTX_set_verify(raw, SSL_VERIFY_PEER, nullptr);
  }
  if (!protocol_.empty())
    SSL_CTX_set_alpn_select_cb(raw, choose_protocol, const_cast<std::string*>(&protocol_));
  return out;
}

}  // namespace driftwise::tls
