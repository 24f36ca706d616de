// An image transport for the tests: lossless PNG of 8 and 16 bits a channel, also where only raw is installed. It shows
// that the node takes its images through any transport and frees them in time. They are freed by code of the plugin, as
// with the templates of the real ones.
#include <image_transport/simple_publisher_plugin.h>
#include <image_transport/simple_subscriber_plugin.h>
#include <sensor_msgs/CompressedImage.h>
#include <opencv2/imgcodecs.hpp>
#include <pluginlib/class_list_macros.hpp>

#include <cv_bridge/cv_bridge.h>

namespace gms_ransac {

class PngPublisher : public image_transport::SimplePublisherPlugin<sensor_msgs::CompressedImage> {
 public:
  std::string getTransportName() const override { return "test_png"; }

 protected:
  void publish(const sensor_msgs::Image& image, const PublishFn& publish_compressed) const override {
    sensor_msgs::CompressedImage compressed;
    compressed.header = image.header;
    compressed.format = image.encoding;
    cv::imencode(".png", cv_bridge::toCvCopy(image)->image, compressed.data);
    publish_compressed(compressed);
  }
};

/// Frees an image; unloaded with the plugin.
struct ImageDeleter {
  void operator()(const sensor_msgs::Image* image) const { delete image; }
};

class PngSubscriber : public image_transport::SimpleSubscriberPlugin<sensor_msgs::CompressedImage> {
 public:
  std::string getTransportName() const override { return "test_png"; }

 protected:
  void internalCallback(const sensor_msgs::CompressedImageConstPtr& compressed, const Callback& user) override {
    cv_bridge::CvImage image(compressed->header, compressed->format);
    image.image = cv::imdecode(compressed->data, cv::IMREAD_UNCHANGED);
    auto* message = new sensor_msgs::Image;
    image.toImageMsg(*message);
    user(sensor_msgs::ImageConstPtr(message, ImageDeleter()));
  }
};

}  // namespace gms_ransac

PLUGINLIB_EXPORT_CLASS(gms_ransac::PngPublisher, image_transport::PublisherPlugin)
PLUGINLIB_EXPORT_CLASS(gms_ransac::PngSubscriber, image_transport::SubscriberPlugin)
