#include "server/access/revoked_certificates.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/stat.h>

#include <cstdio>
#include <ctime>
#include <utility>
#include <vector>

#include "server/core/freed.h"
#include "server/core/reasons.h"
#include "server/core/try.h"

namespace driftwise::access {
namespace {

using HeldList = std::unique_ptr<X509_CRL, Freed<X509_CRL_free>>;
using HeldCertificate = std::unique_ptr<X509, Freed<X509_free>>;
using HeldKey = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using HeldFile = std::unique_ptr<std::FILE, Freed<std::fclose>>;
using HeldBytes = std::unique_ptr<BIO, Freed<BIO_free>>;

// A serial number counts within its issuer.
std::string place_of(const X509_NAME* issuer, const ASN1_INTEGER* serial) {
  unsigned char* bytes = nullptr;
  const int size = i2d_X509_NAME(issuer, &bytes);
  if (size < 0) return {};
  std::string out(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  OPENSSL_free(bytes);
  out += ASN1_STRING_type(serial) == V_ASN1_NEG_INTEGER ? '-' : '+';
  out.append(reinterpret_cast<const char*>(ASN1_STRING_get0_data(serial)),
             static_cast<std::size_t>(ASN1_STRING_length(serial)));
  return out;
}

Result<HeldFile> open_pem(const std::string& path, const char* what) {
  HeldFile file(std::fopen(path.c_str(), "re"));
  if (!file)
    return fail(ErrorCode::not_found, reasons::kNoFile,
                "cannot open the " + std::string(what) + " " + path +
                    ": check the path and its permissions ('driftwise cert init' makes one)");
  return file;
}

// A certificate of the authority's file has signed the list.
bool signed_by(X509_CRL* list, std::FILE* authority) {
  bool good = false;
  while (!good) {
    const HeldCertificate one(PEM_read_X509(authority, nullptr, nullptr, nullptr));
    if (!one) break;
    const HeldKey key(X509_get_pubkey(one.get()));
    good = key && X509_NAME_cmp(X509_get_subject_name(one.get()), X509_CRL_get_issuer(list)) == 0 &&
           X509_CRL_verify(list, key.get()) == 1;
  }
  ERR_clear_error();
  return good;
}

Result<std::vector<HeldList>> read_lists(const std::string& path, const std::string& authority) {
  DRIFTWISE_TRY(const auto file, open_pem(path, "list of revoked certificates"));
  std::vector<HeldList> lists;
  while (HeldList one{PEM_read_X509_CRL(file.get(), nullptr, nullptr, nullptr)})
    lists.push_back(std::move(one));
  ERR_clear_error();
  if (lists.empty())
    return fail(ErrorCode::invalid_argument, reasons::kBadCertificate,
                path +
                    ": found no revocation list in PEM form (-----BEGIN X509 CRL-----); make "
                    "one with 'driftwise cert init'");
  for (const auto& list : lists) {
    DRIFTWISE_TRY(const auto signer, open_pem(authority, "authority"));
    if (!signed_by(list.get(), signer.get()))
      return fail(ErrorCode::invalid_argument, reasons::kBadCertificate,
                  path + ": the authority " + authority +
                      " has not signed this revocation list: give the list of the same authority");
  }
  return lists;
}

}  // namespace

Result<std::unique_ptr<RevokedCertificates>> RevokedCertificates::open(
    const std::string& path, const std::string& authority) {
  DRIFTWISE_RETURN_IF_ERROR(read_lists(path, authority));
  std::unique_ptr<RevokedCertificates> out(new RevokedCertificates(path, authority));
  out->look();
  out->thread_ = std::jthread(
      [book = out.get()](const std::stop_token& ended) { book->look_again_and_again(ended); });
  return out;
}

Result<void> RevokedCertificates::check(const std::string& path, const std::string& authority,
                                        std::int64_t now_utc_s) {
  DRIFTWISE_TRY(const auto lists, read_lists(path, authority));
  std::time_t now = now_utc_s;
  for (const auto& list : lists) {
    const ASN1_TIME* next = X509_CRL_get0_nextUpdate(list.get());
    if (next != nullptr && X509_cmp_time(next, &now) < 0)
      return fail(ErrorCode::failed_precondition, reasons::kCertificateExpired,
                  "the list of revoked certificates " + path +
                      " is older than its authority wants: it holds as it is; put a new one in "
                      "its place ('driftwise cert init' or your authority)");
  }
  return {};
}

RevokedCertificates::Stamp RevokedCertificates::stamp() const {
  struct stat found {};
  if (::stat(path_.c_str(), &found) != 0) return {};
  return {std::int64_t{found.st_mtim.tv_sec} * 1'000'000'000 + found.st_mtim.tv_nsec,
          static_cast<std::uint64_t>(found.st_ino), static_cast<std::uint64_t>(found.st_size)};
}

void RevokedCertificates::look() {
  const Stamp present = stamp();
  if (present == read_) return;
  const auto lists = read_lists(path_, authority_);
  if (!lists) return;
  std::unordered_set<std::string> revoked;
  for (const auto& list : *lists) {
    auto* entries = X509_CRL_get_REVOKED(list.get());
    for (int i = 0; entries != nullptr && i < sk_X509_REVOKED_num(entries); ++i)
      revoked.insert(place_of(X509_CRL_get_issuer(list.get()),
                              X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(entries, i))));
  }
  read_ = present;
  const std::lock_guard lock(mutex_);
  revoked_ = std::move(revoked);
}

void RevokedCertificates::look_again_and_again(const std::stop_token& ended) {
  std::unique_lock lock(sleeping_);
  while (!ended.stop_requested()) {
    woken_.wait_for(lock, ended, kLook, [] { return false; });
    if (!ended.stop_requested()) look();
  }
}

RevokedCertificates::~RevokedCertificates() = default;

bool RevokedCertificates::contains(const std::string& certificate_pem) {
  if (certificate_pem.empty()) return false;
  const std::lock_guard lock(mutex_);
  auto known = known_.find(certificate_pem);
  if (known == known_.end()) {
    const HeldBytes bytes(
        BIO_new_mem_buf(certificate_pem.data(), static_cast<int>(certificate_pem.size())));
    const HeldCertificate one(PEM_read_bio_X509(bytes.get(), nullptr, nullptr, nullptr));
    ERR_clear_error();
    if (!one) return true;
    if (known_.size() >= kMostKnown) known_.clear();
    known = known_
                .emplace(certificate_pem, place_of(X509_get_issuer_name(one.get()),
                                                   X509_get0_serialNumber(one.get())))
                .first;
  }
  return revoked_.contains(known->second);
}

}  // namespace driftwise::access
