/// \file
/// What the image module offers. OpenCV's imgcodecs and videoio bring 240 shared libraries with them and cost 0.7 s
/// when a program starts; they live in a module of their own that is loaded when the first image is read.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace simgap {

/// An open video or camera; made and ended by the module.
class VideoFrames {
 public:
  virtual ~VideoFrames() = default;
  virtual bool read(cv::Mat& image) = 0;  ///< grey; false at the end
  virtual long count() const = 0;         ///< as the file says; 0 when it does not
  virtual double rate() const = 0;        ///< [Hz] as file or camera say; 0 when they do not
};

struct ImageModule {
  bool (*read)(const char* file, cv::Mat& image);                ///< grey, 8 bit; false when it cannot be read
  VideoFrames* (*open_video)(const char* file);                  ///< nullptr when it cannot be opened
  VideoFrames* (*open_camera)(const char* device, double rate);  ///< V4L2; `rate` to ask for [Hz], 0: its own
  bool (*encode_png)(const cv::Mat& image, std::vector<unsigned char>& bytes);
};

/// Loads it on first use. \throws ConfigError when it cannot be loaded
const ImageModule& imageModule();

}  // namespace simgap

extern "C" const simgap::ImageModule* simgapImageModule();
