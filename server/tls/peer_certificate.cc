#include "server/tls/peer_certificate.h"

#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <memory>

#include "server/access/common_name.h"
#include "server/core/freed.h"

namespace driftwise::tls {
namespace {

std::vector<std::string> uris_of(X509* certificate) {
  std::vector<std::string> out;
  const std::unique_ptr<GENERAL_NAMES, Freed<GENERAL_NAMES_free>> names(static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; names && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* one = sk_GENERAL_NAME_value(names.get(), i);
    if (one->type != GEN_URI) continue;
    const auto* text = one->d.uniformResourceIdentifier;
    out.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                     static_cast<std::size_t>(ASN1_STRING_length(text)));
  }
  return out;
}

std::string pem_of(X509* certificate) {
  const std::unique_ptr<BIO, Freed<BIO_free>> bytes(BIO_new(BIO_s_mem()));
  if (!bytes || PEM_write_bio_X509(bytes.get(), certificate) != 1) return {};
  char* data = nullptr;
  const long size = BIO_get_mem_data(bytes.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

}  // namespace

std::optional<PeerCertificate> peer_certificate(SSL* connection) {
  const std::unique_ptr<X509, Freed<X509_free>> certificate(SSL_get1_peer_certificate(connection));
  if (!certificate || SSL_get_verify_result(connection) != X509_V_OK) return std::nullopt;
  return PeerCertificate{access::common_name(X509_get_subject_name(certificate.get())),
                         uris_of(certificate.get()), pem_of(certificate.get())};
}

}  // namespace driftwise::tls
