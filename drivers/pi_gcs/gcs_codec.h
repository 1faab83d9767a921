#pragma once
// PI GCS 2.0, bytes <-> values. Pure: no I/O, no clock.
//
// Facts and where they come from (M maker's manual, D public driver, T tried, U not confirmed):
// - commands and reply lines end with LF; every reply line but the last ends with space LF (D)
// - 0x05 asks the mask of moving axes, in hexadecimal, 0x04 the status word (0x10000: referenced),
// 0x18 stops all axes;
//   single bytes without LF (D)
// - "MOV X 1.5 Y 0" moves all named axes in one command; "POS?", "ONT?", "FRF?", "TMN?", "TMX?"
// answer one
//   "X=<number>" line per axis; "SAI?" one axis name per line (D; FRF?, TMN?, TMX? U)
// - setters are silent; "ERR?" answers one number and clears it (D): of a setter only what was not
//   there before it

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/core/result.h"

namespace driftwise::gcs {

inline constexpr int kNoReferenceOrServo = 5;  // which of the two: FRF? and SVO? say it
inline constexpr int kStoppedError = 10;       // the controller has executed 0x18
inline constexpr char kStatusByte = 0x04, kMovingByte = 0x05, kStopByte = 0x18;
inline constexpr std::uint64_t kStatusReferenced = 0x10000;

// "MOV X 1.5 Y -0.25\n": shortest text that reads back exactly. As many values (mm) as axes.
std::string encode_move(std::span<const std::string> axes, std::span<const double> mm);
// "FRF X Y\n"; "SVO X 1 Y 1\n" with a value.
std::string encode_command(std::string_view command, std::span<const std::string> axes);
std::string encode_switch(std::string_view command, std::span<const std::string> axes, int value);

// All parsers below take one complete reply with or without its line ends. Errors: data_loss,
// reason BAD_REPLY, saying what was expected and found.

// "X=0.1 \nY=2\n" -> values in the order of `axes`; further axes in the reply are passed over.
Result<std::vector<double>> parse_axis_values(std::string_view reply,
                                              std::span<const std::string> axes);
// The same with 0 and 1 only: ONT?, FRF?, SVO?.
Result<std::vector<bool>> parse_axis_flags(std::string_view reply,
                                           std::span<const std::string> axes);
Result<std::vector<std::string>> parse_axis_names(std::string_view reply);  // SAI?
// 0x04, 0x05: hexadecimal with or without 0x.
Result<std::uint64_t> parse_hex(std::string_view reply);
Result<int> parse_error_number(std::string_view reply);  // ERR?

// "7 (position outside limits)".
std::string describe_error(int number);
// The device's own refusal as one of ours: 5 -> failed_precondition NOT_REFERENCED, 7 ->
// out_of_range, 10 -> aborted, ...
Error refusal(int number, std::string_view command);

// Key of the controller by the serial number in its answer to *IDN? ("maker, model, serial number,
// firmware"): "number:C-887:115000001"; empty where it has none (missing, or all zeros).
std::string serial_number_key(std::string_view identity);

}  // namespace driftwise::gcs
