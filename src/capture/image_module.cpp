#include "image_module.h"

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

namespace simgap {
namespace {

bool toGrey(const cv::Mat& image, cv::Mat& grey) {
  if (image.depth() != CV_8U) return false;
  if (image.channels() == 1) {
    image.copyTo(grey);
  } else {
    cv::cvtColor(image, grey, image.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  }
  return true;
}

bool read(const char* file, cv::Mat& image) try {
  image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  return !image.empty();
} catch (const cv::Exception&) {
  return false;
}

class OpenCvVideo : public VideoFrames {
 public:
  explicit OpenCvVideo(const char* file) : capture_(file) {}
  OpenCvVideo(const char* device, double rate) : capture_(device, cv::CAP_V4L2) {
    if (rate > 0.0) capture_.set(cv::CAP_PROP_FPS, rate);
    capture_.set(cv::CAP_PROP_BUFFERSIZE, 1);
  }
  bool isOpen() const { return capture_.isOpened(); }
  bool read(cv::Mat& image) override { return capture_.read(frame_) && toGrey(frame_, image); }
  double rate() const override { return capture_.get(cv::CAP_PROP_FPS); }
  long count() const override { return static_cast<long>(capture_.get(cv::CAP_PROP_FRAME_COUNT)); }

 private:
  mutable cv::VideoCapture capture_;
  cv::Mat frame_;
};

VideoFrames* openVideo(const char* file) try {
  auto video = std::make_unique<OpenCvVideo>(file);
  return video->isOpen() ? video.release() : nullptr;
} catch (const cv::Exception&) {
  return nullptr;
}

VideoFrames* openCamera(const char* device, double rate) try {
  auto camera = std::make_unique<OpenCvVideo>(device, rate);
  return camera->isOpen() ? camera.release() : nullptr;
} catch (const cv::Exception&) {
  return nullptr;
}

bool encodePng(const cv::Mat& image, std::vector<unsigned char>& bytes) try {
  return cv::imencode(".png", image, bytes);
} catch (const cv::Exception&) {
  return false;
}

}  // namespace
}  // namespace simgap

const simgap::ImageModule* simgapImageModule() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors come back as values
  static const simgap::ImageModule module{simgap::read, simgap::openVideo, simgap::openCamera, simgap::encodePng};
  return &module;
}
