#include "datasets/bag_writer.h"
#include "scenes/scene_writer.h"

namespace gms_ransac {

void writeBag(const Scene& scene, int frames, const std::string& path, const std::function<void()>& written) {
  BagWriter bag(path, BagLayout::kTum, scene.intrinsics());
  for (int i = 0; i < frames; ++i) {
    const RenderedFrame frame = scene.render(i);
    bag.writeGroundTruth(frame.stamp, frame.camera_pose);
    bag.writeImage(frame.stamp, frame.image);
    bag.writeDepth(frame.stamp, frame.depth);
    written();
  }
  bag.close();
}

}  // namespace gms_ransac
