#include "simgap/capture/images.h"

#include <fmt/format.h>

#include "image_module.h"
#include "image_names.h"
#include "simgap/core/error.h"
#include "simgap/core/module.h"

namespace simgap {
namespace {

namespace fs = std::filesystem;

class FolderSource : public ImageSource {
 public:
  explicit FolderSource(const fs::path& folder) : folder_(folder.string()), names_(folder) {}

  std::optional<std::size_t> size() const override { return names_.size(); }
  std::string name() const override { return (fs::path(folder_) / names_.at(next_ - 1)).string(); }

  bool next(cv::Mat& image) override {
    if (next_ == names_.size()) return false;
    ++next_;
    if (!imageModule().read(name().c_str(), image)) {
      throw DataError(fmt::format("{}: cannot be read as an image", name()));
    }
    return true;
  }

 private:
  std::string folder_;
  ImageNames names_;
  std::size_t next_ = 0;
};

class VideoSource : public ImageSource {
 public:
  explicit VideoSource(const fs::path& file) : file_(file.string()), video_(imageModule().open_video(file.c_str())) {
    if (video_ == nullptr) {
      throw DataError(
          fmt::format("{}: found no video that can be read, expected a video or a folder of images", file_));
    }
  }

  std::optional<std::size_t> size() const override {
    return video_->count() > 0 ? std::optional(static_cast<std::size_t>(video_->count())) : std::nullopt;
  }
  std::string name() const override { return fmt::format("{}, frame {}", file_, read_ - 1); }

  bool next(cv::Mat& image) override {
    if (!video_->read(image)) return false;
    ++read_;
    return true;
  }

 private:
  std::string file_;
  std::unique_ptr<VideoFrames> video_;
  std::size_t read_ = 0;
};

}  // namespace

const ImageModule& imageModule() {
  using Entry = const ImageModule* (*)();
  static const ImageModule* const loaded = reinterpret_cast<Entry>(moduleEntry("images", "simgapImageModule"))();
  return *loaded;
}

std::unique_ptr<ImageSource> openImages(const std::filesystem::path& path) {
  std::error_code why;
  if (!fs::exists(path, why)) {
    if (!why) why = std::make_error_code(std::errc::no_such_file_or_directory);
    throw ConfigError(fmt::format("{}: cannot be read: {}", path.string(), why.message()));
  }
  if (fs::is_directory(path)) return std::make_unique<FolderSource>(path);
  return std::make_unique<VideoSource>(path);
}

std::string encodePng(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!imageModule().encode_png(image, bytes)) throw NumericsError("an image could not be encoded as PNG");
  return {bytes.begin(), bytes.end()};
}

}  // namespace simgap
