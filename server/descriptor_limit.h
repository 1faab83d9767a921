#pragma once
// Descriptors of this process: a shell gives 1024, which 1000 connections use up.

#include <cstddef>

namespace driftwise {

// Raises the soft limit as far as the hard one allows, to kMostDescriptors. The limit now.
inline constexpr std::size_t kMostDescriptors = 8192;
std::size_t raise_descriptor_limit();

}  // namespace driftwise
