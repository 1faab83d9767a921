#pragma once
// TCP with the addresses of a name from elsewhere.

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/transport/byte_stream.h"

namespace driftwise::transport {

using Endpoints = std::vector<asio::ip::tcp::endpoint>;
using Found = std::function<void(error_code, Endpoints)>;
// Begins to look up the addresses of a host's name and returns at once. Calls `found` on the
// executor's thread, later and at most once; it may be called when nobody waits any more.
using LookUp = std::function<void(const TcpAddress&, Found found)>;

std::unique_ptr<ByteStream> make_tcp_stream(asio::any_io_executor executor, TcpAddress address,
                                            LookUp look_up);

}  // namespace driftwise::transport
