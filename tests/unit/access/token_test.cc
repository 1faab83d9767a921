#include "server/access/token.h"

#include <gtest/gtest.h>

#include <set>

#include "server/access/bearer.h"

namespace driftwise::access {
namespace {

// RFC 7914, section 12; the first 32 bytes of its 64.
TEST(Token, IsHashedByTheScryptOfTheStandard) {
  EXPECT_EQ(digest::hex_from(*scrypt_of("", "", {16, 1, 1})),
            "77d6576238657b203b19ca42c18a0497f16b4844e3074ae8dfdffa3fede21442");
  EXPECT_EQ(digest::hex_from(*scrypt_of("password", "NaCl", {1024, 8, 16})),
            "fdbabe1c9d3472007856e7190d01e9fe7c6ad7cbc8237830e77376634b373162");
}

// FIPS 180-4, "abc".
TEST(Token, IsRememberedByTheSha256OfTheStandard) {
  EXPECT_EQ(digest::hex_from(sha256("abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

// RFC 4648, section 10, in the alphabet of its section 5.
TEST(Token, IsWrittenInTheBase64OfUrls) {
  EXPECT_EQ(base64url("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64url("foob"), "Zm9vYg");
  EXPECT_EQ(base64url("\xfb\xff\xfe"), "-__-");
}

// RFC 7235, 2.1: the scheme is compared without its case; its 4.2 lets the token follow blanks.
TEST(Token, StandsBehindItsSchemeInAnyCase) {
  for (const char* header : {"Bearer dwt_a_b", "bearer dwt_a_b", "BEARER  dwt_a_b"})
    EXPECT_EQ(bearer_in(header), "dwt_a_b") << header;
  for (const char* header : {"", "Basic dwt_a_b", "Bearer", "Bearer ", "Bearerdwt_a_b", "Bear"})
    EXPECT_EQ(bearer_in(header), "") << header;
  EXPECT_EQ(bearer_in("Bearer " + std::string(5000, 'x')).size(), 256U);
}

TEST(Token, ReadsBackItsParts) {
  std::set<std::string> ids, secrets;
  for (int i = 0; i < 200; ++i) {
    const TokenParts fresh = new_token();
    const auto read = token_parts(token_text(fresh));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->id, fresh.id);
    EXPECT_EQ(read->secret, fresh.secret);
    ids.insert(fresh.id);
    secrets.insert(fresh.secret);
  }
  EXPECT_EQ(ids.size(), 200U);
  EXPECT_EQ(secrets.size(), 200U);
}

TEST(Token, IsNoOtherText) {
  const std::string good = token_text(new_token());
  for (std::string bad :
       {std::string(), std::string("dwt_"), good + "x", good.substr(1), good.substr(0, 55),
        " " + good, good + "\n", "DWT" + good.substr(3), std::string(10'000, 'a')})
    EXPECT_EQ(token_parts(bad).error().reason, "BAD_TOKEN");
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = '\0';
    EXPECT_FALSE(token_parts(bad)) << at;
  }
}

}  // namespace
}  // namespace driftwise::access
