#include "server/digest/sha256.h"

#include <openssl/evp.h>

#include <stdexcept>

namespace driftwise::digest {
namespace {

void require(int done) {
  if (done != 1) throw std::runtime_error("the OpenSSL library refuses SHA-256");
}

}  // namespace

struct Sha256::Context {
  struct FreeContext {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  struct FreeAlgorithm {
    void operator()(EVP_MD* algorithm) const { EVP_MD_free(algorithm); }
  };
  // Fetched once for each object: a fetch costs more than the digest of a row.
  std::unique_ptr<EVP_MD, FreeAlgorithm> algorithm{EVP_MD_fetch(nullptr, "SHA256", nullptr)};
  std::unique_ptr<EVP_MD_CTX, FreeContext> state{EVP_MD_CTX_new()};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->algorithm || !context_->state)
    throw std::runtime_error("the OpenSSL library has no SHA-256");
  begin();
}

Sha256::~Sha256() = default;

Sha256& Sha256::begin() {
  require(EVP_DigestInit_ex2(context_->state.get(), context_->algorithm.get(), nullptr));
  return *this;
}

Sha256& Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->state.get(), bytes.data(), bytes.size()));
  return *this;
}

std::string Sha256::finish() {
  std::string bytes(kSha256Bytes, '\0');
  unsigned int length = 0;
  require(EVP_DigestFinal_ex(context_->state.get(), reinterpret_cast<unsigned char*>(bytes.data()),
                             &length));
  return bytes;
}

std::string sha256(std::string_view bytes) { return Sha256().add(bytes).finish(); }

std::string sha256_hex(std::string_view bytes) { return hex_from(sha256(bytes)); }

std::string hex_from(std::string_view bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace driftwise::digest
