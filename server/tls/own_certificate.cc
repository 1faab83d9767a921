#include "server/tls/own_certificate.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <array>
#include <ctime>
#include <memory>

#include "server/access/common_name.h"
#include "server/core/freed.h"
#include "server/core/reasons.h"

namespace driftwise::tls {
namespace {

using Text = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;

Text text_of(const std::string& pem) {
  return Text(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

Certificate certificate_in(const std::string& pem) {
  return Certificate(PEM_read_bio_X509(text_of(pem).get(), nullptr, nullptr, nullptr));
}

std::string subject_of(const Certificate& certificate) {
  return access::common_name(X509_get_subject_name(certificate.get()));
}

std::string day_of(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return "an unknown day";
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

}  // namespace

Result<void> check_pair(const std::string& certificate_pem, const std::string& key_pem) {
  const auto certificate = certificate_in(certificate_pem);
  // No password is asked for: a script has none.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  const Key key(PEM_read_bio_PrivateKey(text_of(key_pem).get(), nullptr, no_password, nullptr));
  const bool together =
      certificate && key && X509_check_private_key(certificate.get(), key.get()) == 1;
  ERR_clear_error();
  if (together) return {};
  if (!certificate || !key)
    return fail(ErrorCode::invalid_argument, reasons::kKeyMismatch,
                std::string("found no ") + (certificate ? "private key" : "certificate") +
                    " in PEM form without a password");
  return fail(ErrorCode::invalid_argument, reasons::kKeyMismatch,
              "the key does not belong to the certificate of '" + subject_of(certificate) +
                  "': give those that were made together");
}

std::string doubts_of(const std::string& certificate_pem, const std::string& authority_pem,
                      std::int64_t now_utc_s) {
  const auto certificate = certificate_in(certificate_pem),
             authority = certificate_in(authority_pem);
  ERR_clear_error();
  if (!certificate) return {};
  const std::string what = "the certificate of '" + subject_of(certificate) + "' ";
  std::time_t now = now_utc_s;
  std::string doubts;
  const auto add = [&](const std::string& doubt) {
    doubts += (doubts.empty() ? "" : "; ") + what + doubt;
  };
  const ASN1_TIME* begin = X509_get0_notBefore(certificate.get());
  const ASN1_TIME* end = X509_get0_notAfter(certificate.get());
  if (X509_cmp_time(end, &now) < 0)
    add("has ended on " + day_of(end) + ": ask for another one (driftwise cert client)");
  if (X509_cmp_time(begin, &now) > 0)
    add("is good from " + day_of(begin) + " on: look at the computer's clock");
  if (authority && X509_NAME_cmp(X509_get_issuer_name(certificate.get()),
                                 X509_get_subject_name(authority.get())) != 0)
    add("was signed by another authority than the daemon's");
  return doubts;
}

}  // namespace driftwise::tls
