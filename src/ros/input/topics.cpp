#include "input/topics.h"

namespace gms_ransac {

namespace {

constexpr int kMostListed = 8;
const std::string kImage = "sensor_msgs/Image", kCompressed = "sensor_msgs/CompressedImage", kEnd = "/compressed";

bool startsWith(const std::string& text, const std::string& start) { return text.compare(0, start.size(), start) == 0; }

/// "/a" of "/a/compressed"; empty for other topics.
std::string baseOfCompressed(const std::string& topic) {
  const bool compressed = topic.size() > kEnd.size() && topic.substr(topic.size() - kEnd.size()) == kEnd;
  return compressed ? topic.substr(0, topic.size() - kEnd.size()) : std::string();
}

}  // namespace

std::string wrongTypes(const std::vector<InputTopic>& inputs, const Topics& published) {
  std::string text;
  for (const InputTopic& input : inputs) {
    const auto found = published.find(input.topic);
    if (found == published.end() || found->second == input.type) continue;
    if (!text.empty()) text += "; ";
    text += "input '" + input.name + "' is remapped to " + input.topic + ", which is a " + found->second +
            "; it must be a " + input.type;
    const std::string base = baseOfCompressed(input.topic);
    if (input.type == kImage && found->second == kCompressed && !base.empty()) {
      text += ": remap it to " + base + " and set ~image_transport to compressed";
    }
  }
  return text;
}

std::string imagesElsewhere(const Topics& published, const std::string& own) {
  std::string text;
  int listed = 0;
  for (const auto& [topic, type] : published) {
    const std::string base = type == kCompressed ? baseOfCompressed(topic) : std::string();
    if ((type != kImage && base.empty()) || published.count(base) > 0 || startsWith(topic, own + "/")) continue;
    if (++listed > kMostListed) return text + ", ...";
    text += (listed == 1 ? "images are published on " : ", ") + topic +
            " (image:=" + (base.empty() ? topic : base + " image_transport:=compressed") + ")";
  }
  return text.empty() ? "no images are published" : text;
}

}  // namespace gms_ransac
