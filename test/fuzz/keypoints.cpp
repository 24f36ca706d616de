// Keypoints messages of any detector: taken as features, or refused with a sentence. The node's answers to a stream of
// them, with masks and depth, are sound, and are drawn without a pixel.
#include <boost/make_shared.hpp>

#include "fuzz_answers.h"
#include "fuzz_messages.h"
#include "gms_ransac/keypoints_view.h"
#include "input/keypoints_conversion.h"
#include "output/message_conversion.h"
#include "output/overlay.h"

namespace gms_ransac {
namespace {

constexpr size_t kMostBytes = 1 << 18;  // of the descriptors

/// A column that is missing, as long as it should be, or not.
template <typename Column, typename Make>
void fill(FuzzInput& input, size_t n, bool needed, Column& column, const Make& make) {
  const uint8_t kind = input.byte();
  if (!needed && kind < 64) return;
  column.resize(kind > 252 ? input.byte() : n);
  for (size_t i = 0; i < column.size(); ++i) column[i] = make(i);
}

/// A wall of points that is seen `shift` pixels further left, with single numbers that break every rule.
Keypoints fuzzedKeypoints(FuzzInput& input, double shift) {
  Keypoints message;
  message.header.frame_id = "camera";
  message.width = input.byte() > 245 ? input.raw<uint32_t>() : 640;
  message.height = input.byte() > 245 ? input.raw<uint32_t>() : 480;
  message.scale_factor = input.byte() > 245 ? input.number32(0, 3) : 1.2f;
  const size_t n = input.byte() < 200 ? static_cast<size_t>(input.between(0, 255)) : input.raw<uint16_t>() % 1200u;
  Random places(1), noise = input.random();
  std::vector<cv::Point2f> points(n);
  for (cv::Point2f& point : points) {
    point.x = static_cast<float>(640 * places.uniform() - shift * (0.5 + places.uniform()));
    point.y = static_cast<float>(479 * places.uniform());
    point.x = std::clamp(point.x, 0.f, 639.f);
  }
  fill(input, n, true, message.u, [&](size_t i) { return i < n ? points[i].x : 0; });
  fill(input, n, true, message.v, [&](size_t i) { return i < n ? points[i].y : 0; });
  fill(input, n, false, message.octave, [&](size_t i) { return static_cast<uint8_t>(i % 8); });
  fill(input, n, false, message.size, [](size_t) { return 31.f; });
  fill(input, n, false, message.angle, [](size_t i) { return static_cast<float>(i % 361); });
  fill(input, n, false, message.response, [](size_t i) { return static_cast<float>(i); });
  fill(input, n, false, message.track_id, [](size_t i) { return static_cast<uint32_t>(i); });
  fill(input, n, false, message.depth, [&](size_t i) { return i % 5 == 0 ? input.number32(-1, 20) : 5.f; });
  message.descriptor_type = input.byte() > 250 ? input.byte() : static_cast<uint8_t>(input.flag());
  static const std::array<uint32_t, 6> kSizes = {32, 4, 64, 61, 512, 1};
  message.descriptor_size = input.byte() > 250 ? input.raw<uint32_t>() : input.oneOf(kSizes);
  size_t bytes = std::min(kMostBytes, n * std::min<size_t>(message.descriptor_size, 512));
  if (input.byte() > 250) bytes = input.raw<uint16_t>();
  message.descriptors.resize(bytes);
  const size_t row = std::clamp<size_t>(message.descriptor_size, 1, 512);
  for (size_t i = 0; i < bytes; ++i) {
    message.descriptors[i] = static_cast<uint8_t>(Random(i / row * 65537 + i % row / 4).next());
    if (message.descriptor_type == Keypoints::DESCRIPTOR_FLOAT32 && i % 4 == 3) message.descriptors[i] = 0x3f;
  }
  for (int k = input.between(0, 6); k > 0 && n > 0; --k) {
    const auto i = static_cast<size_t>(input.between(0, static_cast<int>(n) - 1));
    const int kind = input.between(0, 4);
    if (kind == 0 && i < message.u.size()) message.u[i] = input.number32(-10, 700);
    if (kind == 1 && i < message.v.size()) message.v[i] = input.number32(-10, 700);
    if (kind == 2 && i < message.octave.size()) message.octave[i] = input.byte();
    if (kind == 3 && i < message.angle.size()) message.angle[i] = input.number32(-1, 360);
    if (kind == 4 && i < bytes) message.descriptors[i] = input.byte();
  }
  for (int k = input.between(0, 30); k > 0 && bytes > 0; --k)
    message.descriptors[static_cast<size_t>(noise.below(static_cast<int>(bytes)))] = 0;
  return message;
}

Parameters fuzzedParameters(FuzzInput& input) {
  Parameters parameters;
  parameters.input = InputKind::kKeypoints;
  parameters.scale = input.flag() ? ScaleMode::kDepth : ScaleMode::kUnit;
  if (input.flag()) parameters.camera = {500, 500, 320, 240, "", {}};
  return parameters;
}

void checkAnswer(const ProcessedFrame& processed, FuzzInput& input, Overlay& overlay) {
  demandSound(processed);
  overlay.add(processed);
  if (processed.status == MatchStats::BAD_IMAGE) return;
  Keypoints published;
  toMessage(processed, published);
  demand(published.u.size() == published.v.size() && published.depth.size() <= published.u.size(), "columns agree");
  demand(KeypointsView<Keypoints>(published).size() == processed.current->frame.features.size(),
         "it can be read again");
  const double area = processed.current->imageSize().area();
  if (area > 0 && area < 1e7) {
    overlay.draw(processed,
                 {static_cast<OverlayColour>(input.between(0, 4)), static_cast<OverlayLayout>(input.flag())});
  }
}

}  // namespace

void check(FuzzInput input) {
  quietRos();
  FrameProcessor processor(fuzzedParameters(input), "/image", "/camera_info");
  ProcessorOptions options;
  options.core.robust.max_iterations = 50;
  processor.setOptions(options);
  Overlay overlay;
  for (int i = 0; i < 3 && !input.empty(); ++i) {
    const auto message = boost::make_shared<Keypoints>(fuzzedKeypoints(input, 8 * i));
    message->header.stamp = ros::Time(100 + 0.1 * i);
    Features features;
    const std::string problem = toFeatures(*message, features);
    demand(problem.size() < 1000, "a refusal is short whatever the message says");
    demand(problem.empty() || features.keypoints.empty(), "features or a sentence");
    // Larger tables and masks take seconds and a gigabyte, and are of the same kind.
    if (problem.empty() && int64_t{features.image_size.width} * features.image_size.height > 4000000) continue;
    ImageWithInfo with_info;
    const auto image = boost::make_shared<sensor_msgs::Image>();
    image->header = message->header;
    image->width = message->width;
    image->height = message->height;
    with_info.image = image;
    with_info.keypoints = message;
    if (input.flag()) with_info.camera_info = fuzzedCameraInfo(input, 640, 480);
    if (input.byte() > 200) with_info.mask = fuzzedImage(input, std::vector<std::string>{"mono8"}, 160);
    with_info.received = message->header.stamp;
    checkAnswer(processor.process(processor.prepare(processor.receive(with_info))), input, overlay);
  }
}

}  // namespace gms_ransac
