#include "input/topics.h"

#include <algorithm>

namespace gms_ransac {

namespace {

constexpr int kMostListed = 8;
const std::string kImage = "sensor_msgs/Image", kCompressed = "sensor_msgs/CompressedImage", kEnd = "/compressed";

/// The overlay or the learned mask of a match filter, of this node or another.
bool isOfMatchFilter(const std::string& topic, const Topics& published) {
  for (const char* const image : {"/match_image", "/learned_mask"}) {
    const auto stats = published.find(topic.substr(0, topic.find(image)) + "/stats");
    if (stats != published.end() && stats->second == "gms_ransac/MatchStats") return true;
  }
  return false;
}

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

std::string imagesElsewhere(const Topics& published, const std::string& name, const std::vector<InputTopic>& inputs) {
  const bool depth = name == "depth/image";
  std::string text;
  int listed = 0;
  for (const auto& [topic, type] : published) {
    const std::string base = type == kCompressed && !depth ? baseOfCompressed(topic) : std::string();
    if ((type != kImage && base.empty()) || published.count(base) > 0 || isOfMatchFilter(topic, published)) continue;
    const auto is_this = [&topic = topic](const InputTopic& input) { return input.topic == topic; };
    if (std::any_of(inputs.begin(), inputs.end(), is_this)) continue;
    if (depth && topic.find("depth") == std::string::npos) continue;
    if (++listed > kMostListed) return text + ", ...";
    text += (listed == 1 ? "images are published on " : ", ") + topic + " (" + name +
            ":=" + (base.empty() ? topic : base + ", ~image_transport compressed") + ")";
  }
  if (!text.empty()) return text;
  return depth ? "no other topic with depth in its name has images" : "no other images are published";
}

}  // namespace gms_ransac
