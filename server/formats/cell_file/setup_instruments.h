#pragma once
// Which device a set-up of a cell file names for each coordinate, or the file without one. Of a
// file that another program's drivers were needed for, too: nothing but [[setup]] and what devices
// declare as their length is looked at.

#include <map>
#include <string>
#include <string_view>

namespace driftwise::formats {

// Id of the device by symbol ("ma.z"); empty: the file has no such set-up, or is none.
std::map<std::string, std::string> setup_instruments(std::string_view cell_text,
                                                     std::string_view setup);
// Of each length that one device alone declares. A run without a set-up has these.
std::map<std::string, std::string> length_instruments(std::string_view cell_text);

}  // namespace driftwise::formats
