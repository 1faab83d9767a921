#include "server/access/certificate.h"

#include <arpa/inet.h>
#include <openssl/asn1.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <ctime>
#include <memory>

#include "server/access/common_name.h"
#include "server/core/freed.h"
#include "server/core/reasons.h"
#include "server/core/text/clean_text.h"
#include "server/core/try.h"

namespace driftwise::access {
namespace {

using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using File = std::unique_ptr<std::FILE, Freed<std::fclose>>;

Result<File> open_file(const std::string& path, const char* what) {
  File file(std::fopen(path.c_str(), "re"));
  if (!file)
    return fail(ErrorCode::not_found, reasons::kNoFile,
                "cannot open the " + std::string(what) + " " + path +
                    ": check the path and its permissions ('driftwise cert init' makes one)");
  return file;
}

std::int64_t utc_s(const ASN1_TIME* time) {
  std::tm parts{};
  return ASN1_TIME_to_tm(time, &parts) == 1 ? static_cast<std::int64_t>(timegm(&parts)) : 0;
}

std::string text_of(const ASN1_STRING* text) {
  return clean_line({reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                     static_cast<std::size_t>(ASN1_STRING_length(text))});
}

std::string address_text(const ASN1_OCTET_STRING* bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int family = ASN1_STRING_length(bytes) == 4 ? AF_INET : AF_INET6;
  if (family == AF_INET6 && ASN1_STRING_length(bytes) != 16) return "";
  ::inet_ntop(family, ASN1_STRING_get0_data(bytes), text.data(), text.size());
  return text.data();
}

CertificateFacts facts_of(const X509* certificate) {
  CertificateFacts facts;
  facts.subject = common_name(X509_get_subject_name(certificate));
  facts.issuer = common_name(X509_get_issuer_name(certificate));
  facts.not_before_utc_s = utc_s(X509_get0_notBefore(certificate));
  facts.not_after_utc_s = utc_s(X509_get0_notAfter(certificate));
  const std::unique_ptr<GENERAL_NAMES, Freed<GENERAL_NAMES_free>> names(static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
  for (int i = 0; names && i < sk_GENERAL_NAME_num(names.get()); ++i) {
    const GENERAL_NAME* one = sk_GENERAL_NAME_value(names.get(), i);
    if (one->type == GEN_DNS) facts.names.push_back(text_of(one->d.dNSName));
    if (one->type == GEN_IPADD) facts.names.push_back(address_text(one->d.iPAddress));
    if (one->type == GEN_URI) facts.uris.push_back(text_of(one->d.uniformResourceIdentifier));
  }
  return facts;
}

Result<Certificate> load_certificate(const std::string& path) {
  DRIFTWISE_TRY(const auto file, open_file(path, "certificate"));
  Certificate certificate(PEM_read_X509(file.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (!certificate)
    return fail(ErrorCode::invalid_argument, reasons::kBadCertificate,
                path + ": found no certificate in PEM form (-----BEGIN CERTIFICATE-----)");
  return certificate;
}

Result<Key> load_key(const std::string& path) {
  DRIFTWISE_TRY(const auto file, open_file(path, "key"));
  struct stat about {};
  if (::fstat(::fileno(file.get()), &about) == 0 && (about.st_mode & 077U) != 0)
    return fail(ErrorCode::failed_precondition, reasons::kFileReadable,
                path + " holds a private key and is open to other users: chmod 600 " + path);
  // No password is asked for at a terminal: a daemon has none.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  Key key(PEM_read_PrivateKey(file.get(), nullptr, no_password, nullptr));
  ERR_clear_error();
  if (!key)
    return fail(ErrorCode::invalid_argument, reasons::kBadKey,
                path + ": found no private key in PEM form without a password");
  return key;
}

}  // namespace

std::string day_of(std::int64_t at_utc_s) {
  const std::time_t time = at_utc_s;
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

Result<CertificateFacts> read_certificate(const std::string& path) {
  DRIFTWISE_TRY(const auto certificate, load_certificate(path));
  return facts_of(certificate.get());
}

Result<CertificateFacts> certificate_from(const std::string& pem) {
  const std::unique_ptr<BIO, Freed<BIO_free_all>> text(
      BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  const Certificate certificate(PEM_read_bio_X509(text.get(), nullptr, nullptr, nullptr));
  ERR_clear_error();
  if (!certificate)
    return fail(ErrorCode::invalid_argument, reasons::kBadCertificate,
                "found no certificate in PEM form (-----BEGIN CERTIFICATE-----)");
  return facts_of(certificate.get());
}

Result<CertificateFacts> check_files(const std::string& certificate, const std::string& key) {
  DRIFTWISE_TRY(const auto loaded, load_certificate(certificate));
  DRIFTWISE_TRY(const auto private_key, load_key(key));
  const bool together = X509_check_private_key(loaded.get(), private_key.get()) == 1;
  ERR_clear_error();
  if (!together)
    return fail(ErrorCode::failed_precondition, reasons::kKeyMismatch,
                "the key " + key + " does not belong to the certificate " + certificate +
                    ": give those that were made together");
  return facts_of(loaded.get());
}

Result<CertificateFacts> check_certificate(const std::string& certificate, const std::string& key,
                                           std::int64_t now_utc_s) {
  DRIFTWISE_TRY(auto facts, check_files(certificate, key));
  if (now_utc_s < facts.not_before_utc_s || now_utc_s >= facts.not_after_utc_s)
    return fail(ErrorCode::failed_precondition, reasons::kCertificateExpired,
                certificate + " is good from " + day_of(facts.not_before_utc_s) + " to " +
                    day_of(facts.not_after_utc_s) + ", today is " + day_of(now_utc_s) +
                    ": clients refuse it; look at the computer's clock, or make a new one "
                    "('driftwise cert init' or your authority), no restart is needed");
  return facts;
}

std::string expiry_warning(const std::string& path, const CertificateFacts& facts,
                           std::int64_t now_utc_s) {
  constexpr std::int64_t kDay = 86'400;
  const std::int64_t left_s = facts.not_after_utc_s - now_utc_s;
  if (left_s > kExpiryWarningDays * kDay) return {};
  const std::string what = "the certificate " + path + " of '" + facts.subject + "' ";
  const std::string then =
      ": put a new certificate and key in the place of the files; no restart is needed";
  if (left_s <= 0)
    return what + "has ended on " + day_of(facts.not_after_utc_s) + ", clients refuse the daemon" +
           then;
  return what + "ends on " + day_of(facts.not_after_utc_s) + ", in " +
         std::to_string(left_s / kDay) + " days" + then;
}

}  // namespace driftwise::access
