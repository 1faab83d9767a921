#pragma once
// Sentence of an alarm for people, who see no field "subject" beside it.

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace driftwise {

// "database: the record takes nothing"; the sentence alone where it has every word of the subject:
// "t07_degC is 21.5: a limit is above 21" of "t07_degC above 21".
inline std::string with_subject(std::string_view subject, std::string_view sentence) {
  const auto is_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  const auto has = [&](std::string_view word) {
    for (auto at = sentence.find(word); at != std::string_view::npos;
         at = sentence.find(word, at + 1)) {
      const auto end = at + word.size();
      if ((at == 0 || !is_word(sentence[at - 1])) &&
          (end == sentence.size() || !is_word(sentence[end])))
        return true;
    }
    return false;
  };
  for (std::size_t at = 0; at < subject.size();) {
    const auto end = std::min(subject.find(' ', at), subject.size());
    if (end > at && !has(subject.substr(at, end - at)))
      return std::string(subject) + ": " + std::string(sentence);
    at = end + 1;
  }
  return std::string(sentence);
}

}  // namespace driftwise
