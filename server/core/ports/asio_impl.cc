// Asio's own functions, compiled once for all rooms: BOOST_ASIO_SEPARATE_COMPILATION in
// driftwise_asio.

#include <boost/asio/impl/src.hpp>
