#pragma once

#include <string>
#include <string_view>

namespace driftwise::transport {

// Raw bytes for people: printable ASCII as it stands, the rest as \r \n \\ \" or \x1b, cut after
// max_bytes with "...(+N bytes)". What error messages and the exchange log show.
std::string escaped(std::string_view bytes, std::size_t max_bytes = 160);

}  // namespace driftwise::transport
