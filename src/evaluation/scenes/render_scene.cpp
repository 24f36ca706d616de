// Program: renders a textured 3-D scene with exact poses and depth, to a folder in TUM layout or to a bag.
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>

#include <boost/lexical_cast.hpp>
#include <boost/program_options.hpp>

#include "program.h"
#include "scenes/scene_writer.h"

namespace {

namespace po = boost::program_options;
using namespace gms_ransac;

std::vector<double> parseNumbers(const std::string& text, const std::string& option) {
  std::vector<double> numbers;
  for (const std::string& word : splitAtCommas({text})) {
    if (!boost::conversion::try_lexical_convert(word, numbers.emplace_back())) {
      throw std::invalid_argument(option + ": '" + word + "' is not a number");
    }
  }
  return numbers;
}

int renderScene(const Arguments& arguments) {
  SceneOptions scene_options;
  int frames = 90;
  std::string out, distortion;
  po::options_description options;
  auto add = options.add_options();
  add("frames,n", withDefault(frames), "frames to render");
  add("scene", withDefault(scene_options.scene), "room or street");
  add("width", withDefault(scene_options.size.width), "pixels");
  add("height", withDefault(scene_options.size.height), "pixels");
  add("focal-length", withDefault(scene_options.focal_length), "pixels; 0: 525 per 640 of width");
  add("distortion", po::value(&distortion), "plumb_bob k1,k2,p1,p2[,k3]; default none");
  add("step", withDefault(scene_options.step),
      "metres of path per frame; negative: 0.08 in the room, 0.3 in the street; 0: the camera only rotates");
  add("turn", withDefault(scene_options.turn), "additional heading per frame, degrees");
  add("sway", withDefault(scene_options.sway), "factor on the slow hand motion, 0..3");
  add("offset", withDefault(scene_options.offset),
      "metres that the camera is moved to its right: once without and once with it, a stereo pair");
  add("rate", withDefault(scene_options.rate), "frames per second");
  add("grey", po::bool_switch(), "grey images instead of colour");
  add("noise", withDefault(scene_options.noise), "standard deviation, grey levels");
  add("blur", withDefault(scene_options.blur), "standard deviation, pixels");
  add("movers", withDefault(scene_options.movers), "boards that sway before the camera by themselves");
  add("repetition", withDefault(scene_options.repetition), "textures repeat themselves after so many metres; 0: not");
  add("readout", withDefault(scene_options.readout),
      "rolling shutter: share of the time between frames in which the rows are read");
  add("exposure", withDefault(scene_options.exposure),
      "motion blur: share of the time between frames in which the shutter is open");
  add("brightness", withDefault(scene_options.brightness), "factor on the image before its noise, 0..1");
  add("seed", withDefault(scene_options.seed), "of textures, furniture and noise");
  const char* usage =
      "render_scene OUT [options]\n\nRenders a textured 3-D scene seen from a moving camera. OUT is a folder (TUM "
      "layout:\nrgb.txt, depth.txt, groundtruth.txt, camera.txt) or a file that ends in .bag (topics of the\nofficial "
      "TUM bags). Poses, depth and intrinsics are exact.";
  const auto given = parseCommandLine(arguments, usage, options, {{"out", 1, po::value(&out)}});
  if (!given) return 0;
  if (out.empty()) throw std::invalid_argument("no output given; see render_scene --help");
  requireAtLeastOne({{"--frames", frames}});
  scene_options.colour = !(*given)["grey"].as<bool>();
  scene_options.distortion = parseNumbers(distortion, "--distortion");

  const Scene scene(scene_options);
  if (frames > scene.frameCount()) {
    throw std::invalid_argument("--frames is " + std::to_string(frames) + "; the path ends after " +
                                std::to_string(scene.frameCount()) + " frames of this step");
  }
  watchInterrupts();
  Progress progress("rendering frame", frames);
  const bool bag = std::filesystem::path(out).extension() == ".bag";
  (bag ? writeBag : writeTumFolder)(scene, frames, out, [&progress] { progress.advanceUnlessInterrupted(); });
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return gms_ransac::runProgram(argc, argv, renderScene); }
