#pragma once
// Descriptors of this process: a shell gives 1024, which 1000 connections use up.

#include <cstddef>

namespace driftwise {

// Raises the soft limit as far as the hard one allows, to this many at most. The limit now.
std::size_t raise_descriptor_limit(std::size_t wanted = 8192);

}  // namespace driftwise
