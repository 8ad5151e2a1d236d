#include "unit_words.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "columns.hpp"

namespace fricid::data {
namespace {

struct Word {
  std::string_view word;
  UnitWord means;
};
constexpr auto kTimes = std::to_array<Word>({{"s", {"s"}},
                                             {"sec", {"s"}},
                                             {"second", {"s"}},
                                             {"seconds", {"s"}},
                                             {"ms", {"ms"}},
                                             {"msec", {"ms"}},
                                             {"us", {"us"}},
                                             {"\u00B5s", {"us"}},
                                             {"\u03BCs", {"us"}},
                                             {"usec", {"us"}},
                                             {"ns", {"ns"}},
                                             {"nsec", {"ns"}}});
// rates of them are written with /s; a sliding joint in metres has the unit rad
constexpr auto kMotions = std::to_array<Word>({{"rad", {"rad"}},
                                               {"radian", {"rad"}},
                                               {"radians", {"rad"}},
                                               {"deg", {"deg"}},
                                               {"degree", {"deg"}},
                                               {"degrees", {"deg"}},
                                               {"\u00B0", {"deg"}},
                                               {"m", {"rad"}},
                                               {"cm", {"rad", 1e-2}},
                                               {"mm", {"rad", 1e-3}}});
constexpr auto kTorques = std::to_array<Word>({{"nm", {""}},
                                               {"knm", {"", 1e3}},
                                               {"ncm", {"", 1e-2}},
                                               {"mnm", {"", 1e-3}},
                                               {"nmm", {"", 1e-3}}});
constexpr auto kTemperatures = std::to_array<Word>({{"k", {"K"}},
                                                    {"kelvin", {"K"}},
                                                    {"c", {"C"}},
                                                    {"\u00B0c", {"C"}},
                                                    {"degc", {"C"}},
                                                    {"celsius", {"C"}}});

// A cell in lower case without brackets, spaces and the signs between units that are multiplied.
std::string bare(std::string_view cell) {
  std::string word = lower_case(cell);
  for (const std::string_view sign : {"\u00B7", "[", "]", "(", ")", "*", ".", " "})
    for (std::size_t at = word.find(sign); at != std::string::npos; at = word.find(sign))
      word.erase(at, sign.size());
  return word;
}

std::optional<UnitWord> named(std::span<const Word> words, std::string_view cell) {
  std::string word = bare(cell);
  for (const std::string_view rate : {"/sec", "/s", "s^-1", "s-1"})
    if (word.ends_with(rate) && word.size() > rate.size()) word.erase(word.size() - rate.size());
  const auto known = std::ranges::find(words, word, &Word::word);
  return known == words.end() ? std::nullopt : std::optional(known->means);
}

}  // namespace

std::optional<UnitWord> time_unit(std::string_view cell) { return named(kTimes, cell); }
std::optional<UnitWord> motion_unit(std::string_view cell) { return named(kMotions, cell); }
std::optional<UnitWord> torque_unit(std::string_view cell) { return named(kTorques, cell); }
std::optional<UnitWord> temperature_unit(std::string_view cell) {
  return named(kTemperatures, cell);
}

bool is_unit(std::string_view cell) {
  constexpr auto kOthers = std::to_array<std::string_view>({"", "-", "1", "%", "a", "ma", "v"});
  return time_unit(cell) || motion_unit(cell) || torque_unit(cell) || temperature_unit(cell) ||
         std::ranges::count(kOthers, bare(cell)) > 0;
}

}  // namespace fricid::data
