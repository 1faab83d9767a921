#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace driftwise::notify {

struct Mail {
  std::string from;
  std::vector<std::string> to;
  std::string subject, text, message_id;
  std::int64_t unix_s = 0;
};

// The mail as RFC 5322 has it, lines ended by CR LF: the text in UTF-8 as base64, the subject as
// encoded words (RFC 2047) where it is not plain ASCII.
std::string rfc5322(const Mail& mail);

}  // namespace driftwise::notify
