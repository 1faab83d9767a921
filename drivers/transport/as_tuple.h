#pragma once
// How this room waits on Asio: co_await gives (error, ...) as values; nothing is thrown.

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace driftwise::transport {

inline constexpr auto kAsTuple = boost::asio::as_tuple(boost::asio::use_awaitable);

}  // namespace driftwise::transport
