#include "command_line.h"

#include <iostream>
#include <sstream>
#include <stdexcept>

namespace gms_ransac {

namespace po = boost::program_options;

std::optional<po::variables_map> parseCommandLine(const Arguments& arguments, const std::string& usage,
                                                  const po::options_description& options,
                                                  const std::vector<Positional>& positional) {
  po::options_description all;
  all.add(options);
  po::positional_options_description places;
  for (const Positional& words : positional) {
    all.add_options()(words.name, words.value);
    places.add(words.name, words.count);
  }
  po::command_line_parser parser(arguments);
  parser.options(all).positional(places);
  po::variables_map given;
  po::store(parser.run(), given);
  po::notify(given);
  if (given.count("help") == 0) return given;
  std::cout << usage << "\n\n" << options;
  return std::nullopt;
}

void addDatasetOptions(po::options_description& description, DatasetOptions& dataset) {
  auto add = description.add_options();
  add("intrinsics", po::value(&dataset.intrinsics), "fx,fy,cx,cy[,k1,k2,p1,p2[,k3]]; overrides the set's own");
  add("topic", po::value(&dataset.topic), "bags: the image topic");
}

void requireAtLeastOne(std::initializer_list<std::pair<const char*, int>> options) {
  for (const auto& [name, value] : options) {
    if (value >= 1) continue;
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) + "; it must be at least 1");
  }
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

std::vector<int> parsePositives(const std::string& list, const std::string& option) {
  std::vector<int> numbers;
  for (const std::string& word : splitAtCommas(list)) {
    std::istringstream stream(word);
    int number = 0;
    if (!(stream >> number) || !stream.eof() || number < 1) {
      throw std::invalid_argument(option + " holds '" + word + "'; it takes whole numbers from 1 on");
    }
    numbers.push_back(number);
  }
  if (numbers.empty()) throw std::invalid_argument(option + " is empty; it takes whole numbers from 1 on");
  return numbers;
}

}  // namespace gms_ransac
