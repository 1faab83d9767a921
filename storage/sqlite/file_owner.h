#pragma once
// Owner of what root writes into a cell's folder. The service runs as a user of its own; a person
// who stops it, restores its record or makes its certificate is root.

#include <string>

namespace driftwise::storage {

// By root: the file or folder belongs to whom the folder around it belongs. By others: nothing.
void give_to_owner_of_folder(const std::string& path);

}  // namespace driftwise::storage
