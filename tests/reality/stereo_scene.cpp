#include "reality/stereo_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

namespace simgap::reality {
namespace {

Eigen::Vector2d distort(const Lens& lens, const Eigen::Vector2d& p) {
  const double r2 = p.squaredNorm();
  const double radial = 1.0 + lens.k1 * r2 + lens.k2 * r2 * r2;
  return {p.x() * radial + 2.0 * lens.p1 * p.x() * p.y() + lens.p2 * (r2 + 2.0 * p.x() * p.x()),
          p.y() * radial + lens.p1 * (r2 + 2.0 * p.y() * p.y()) + 2.0 * lens.p2 * p.x() * p.y()};
}

void blurRows(std::vector<float>& image, int width, int height, const std::vector<float>& kernel) {
  const int reach = int(kernel.size()) / 2;
  std::vector<float> row(std::size_t(width + 2 * reach));
  for (int y = 0; y < height; ++y) {
    float* line = image.data() + std::size_t(y) * std::size_t(width);
    if (std::all_of(line, line + width, [](float v) { return v == 0.0F; })) continue;
    std::fill(row.begin(), row.end(), 0.0F);
    std::copy(line, line + width, row.begin() + reach);
    for (int x = 0; x < width; ++x) {
      float sum = 0.0F;
      for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * row[std::size_t(x) + k];
      line[x] = sum;
    }
  }
}

std::vector<float> transposed(const std::vector<float>& image, int width, int height) {
  std::vector<float> result(image.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      result[std::size_t(x) * std::size_t(height) + std::size_t(y)] =
          image[std::size_t(y) * std::size_t(width) + std::size_t(x)];
    }
  }
  return result;
}

// A Gaussian integrated over each pixel's step.
std::vector<float> gaussian(double sigma) {
  const int reach = int(std::ceil(4.0 * sigma));
  std::vector<float> kernel;
  for (int i = -reach; i <= reach; ++i) {
    const auto below = [&](double x) { return 0.5 * std::erfc(-x / (sigma * std::sqrt(2.0))); };
    kernel.push_back(float(below(i + 0.5) - below(i - 0.5)));
  }
  return kernel;
}

// 2^16 standard normal quantiles: a random 16-bit word picks one. Good enough for sensor noise, and fast.
const std::vector<float>& normalTable() {
  static const std::vector<float> table = [] {
    std::vector<float> values(1U << 16);
    std::mt19937_64 engine(7);
    std::normal_distribution<float> normal;
    for (float& value : values) value = normal(engine);
    return values;
  }();
  return table;
}

std::string matrix(const char* name, int rows, int cols, const std::vector<double>& values) {
  std::ostringstream out;
  out.precision(17);
  out << name << ": !!opencv-matrix\n   rows: " << rows << "\n   cols: " << cols << "\n   dt: d\n   data: [ ";
  for (std::size_t i = 0; i < values.size(); ++i) out << (i ? ", " : "") << values[i];
  out << " ]\n";
  return out.str();
}

}  // namespace

Eigen::Vector2d Lens::project(const Eigen::Vector3d& point) const {
  const Eigen::Vector2d bent = distort(*this, point.head<2>() / point.z());
  return {fx * bent.x() + cx, fy * bent.y() + cy};
}

Eigen::Vector3d Lens::ray(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d target((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Eigen::Vector2d p = target;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d error = target - distort(*this, p);
    p += error;
    if (error.norm() < 1e-12) break;
  }
  return {p.x(), p.y(), 1.0};
}

StereoLenses standardLenses(int scale) {
  StereoLenses lenses;
  lenses.left = {640, 480, 800.0, 800.8, 323.1, 235.8, -0.11, 0.05, 4e-4, -3e-4};
  lenses.right = {640, 480, 802.4, 801.6, 314.6, 242.7, -0.10, 0.04, -2e-4, 5e-4};
  for (Lens* lens : {&lenses.left, &lenses.right}) {
    lens->width *= scale;
    lens->height *= scale;
    lens->fx *= scale;
    lens->fy *= scale;
    lens->cx = (lens->cx + 0.5) * scale - 0.5;
    lens->cy = (lens->cy + 0.5) * scale - 0.5;
  }
  lenses.rotation = (Eigen::AngleAxisd(0.24, Eigen::Vector3d::UnitY()) *
                     Eigen::AngleAxisd(0.005, Eigen::Vector3d(1, 0, 1).normalized()))
                        .toRotationMatrix();
  lenses.translation = {-0.348, 0.003, 0.042};
  return lenses;
}

std::string stereoYaml(const StereoLenses& lenses) {
  const auto camera = [](const Lens& lens, const std::string& side) {
    return matrix(("K" + side).c_str(), 3, 3, {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1}) +
           matrix(("D" + side).c_str(), 1, 4, {lens.k1, lens.k2, lens.p1, lens.p2});
  };
  std::vector<double> rotation;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rotation.push_back(lenses.rotation(r, c));
  }
  const Eigen::Vector3d& t = lenses.translation;
  return "%YAML:1.0\n---\nimage_width: " + std::to_string(lenses.left.width) +
         "\nimage_height: " + std::to_string(lenses.left.height) + "\n" + camera(lenses.left, "1") +
         camera(lenses.right, "2") + matrix("R", 3, 3, rotation) + matrix("T", 3, 1, {t.x(), t.y(), t.z()});
}

void Image::writePgm(const std::filesystem::path& file) const {
  std::ofstream out(file, std::ios::binary);
  out << "P5\n" << width << " " << height << "\n255\n";
  out.write(reinterpret_cast<const char*>(pixels.data()), std::streamsize(pixels.size()));
}

Camera::Camera(const Lens& lens, const Light& light) : lens_(lens), light_(light) {
  // One column and row more than pixels, so that every pixel has a neighbour to interpolate towards.
  for (int y = 0; y <= lens.height; ++y) {
    for (int x = 0; x <= lens.width; ++x) {
      rays_.push_back(lens.ray({double(x), double(y)}).head<2>().cast<float>());
    }
  }
}

void Camera::draw(const Sphere& sphere, std::vector<float>& light) const {
  constexpr int kSamples = 4;  // per pixel and direction
  if (sphere.centre.z() <= sphere.radius) return;
  const double distance = sphere.centre.norm();
  const double sine = sphere.radius / distance;
  const Eigen::Vector3d towards = sphere.centre / distance;
  const Eigen::Vector2d middle = lens_.project(sphere.centre);
  const double reach = 1.3 * lens_.fx * sphere.radius / sphere.centre.z() + 3.0;
  const double sample_step = 1.0 / (lens_.fx * kSamples);  // [rad], roughly
  const auto bound = [](double value, int size) { return std::clamp(int(value), 0, size); };
  for (int y = bound(middle.y() - reach, lens_.height); y < bound(middle.y() + reach + 1, lens_.height); ++y) {
    for (int x = bound(middle.x() - reach, lens_.width); x < bound(middle.x() + reach + 1, lens_.width); ++x) {
      const std::size_t at = std::size_t(y) * std::size_t(lens_.width + 1) + std::size_t(x);
      const Eigen::Vector2d ray = rays_[at].cast<double>();
      const Eigen::Vector2d along_x = rays_[at + 1].cast<double>() - ray;
      const Eigen::Vector2d along_y = rays_[at + std::size_t(lens_.width) + 1].cast<double>() - ray;
      double covered = 0.0;
      double shine = 0.0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const double dx = (i % kSamples + 0.5) / kSamples - 0.5;
        const double dy = (i / kSamples + 0.5) / kSamples - 0.5;
        const Eigen::Vector2d p = ray + dx * along_x + dy * along_y;
        const double off_axis = Eigen::Vector3d(p.x(), p.y(), 1.0).normalized().cross(towards).norm();
        // A ray meets the sphere when it passes within its angular radius; the rim is one sample wide.
        const double inside = std::clamp((sine - off_axis) / sample_step + 0.5, 0.0, 1.0);
        const double depth = std::sqrt(std::max(0.0, 1.0 - off_axis * off_axis / (sine * sine)));
        covered += inside;
        shine += inside * (0.75 + 0.25 * depth);  // a retro-reflector fades a little towards its rim
      }
      float& pixel = light[std::size_t(y) * std::size_t(lens_.width) + std::size_t(x)];
      pixel = float(pixel * (1.0 - covered / (kSamples * kSamples)) +
                    light_.peak * sphere.brightness * shine / (kSamples * kSamples));
    }
  }
}

Image Camera::render(const std::vector<std::vector<Sphere>>& exposures, const std::vector<Spot>& spots,
                     std::uint64_t seed) const {
  const std::size_t pixels = std::size_t(lens_.width) * std::size_t(lens_.height);
  std::vector<float> light(pixels, 0.0F);
  for (std::vector<Sphere> spheres : exposures) {
    std::sort(spheres.begin(), spheres.end(), [](const Sphere& a, const Sphere& b) {
      return a.centre.squaredNorm() > b.centre.squaredNorm();  // what is far is painted over
    });
    std::vector<float> moment(exposures.size() > 1 ? pixels : 0, 0.0F);
    std::vector<float>& canvas = exposures.size() > 1 ? moment : light;
    for (const Sphere& sphere : spheres) draw(sphere, canvas);
    for (std::size_t i = 0; i < moment.size(); ++i) light[i] += moment[i] / float(exposures.size());
  }
  for (const Spot& spot : spots) {
    const int reach = int(std::ceil(5.0 * spot.sigma));
    for (int y = std::max(0, int(spot.pixel.y()) - reach); y <= std::min(lens_.height - 1, int(spot.pixel.y()) + reach);
         ++y) {
      for (int x = std::max(0, int(spot.pixel.x()) - reach);
           x <= std::min(lens_.width - 1, int(spot.pixel.x()) + reach); ++x) {
        const double square = (Eigen::Vector2d(x, y) - spot.pixel).squaredNorm() / (spot.sigma * spot.sigma);
        light[std::size_t(y) * std::size_t(lens_.width) + std::size_t(x)] += float(spot.peak * std::exp(-0.5 * square));
      }
    }
  }
  if (light_.blur > 0.0) {
    const std::vector<float> kernel = gaussian(light_.blur);
    blurRows(light, lens_.width, lens_.height, kernel);
    light = transposed(light, lens_.width, lens_.height);
    blurRows(light, lens_.height, lens_.width, kernel);
    light = transposed(light, lens_.height, lens_.width);
  }
  Image image{lens_.width, lens_.height, std::vector<std::uint8_t>(pixels)};
  std::mt19937_64 engine(seed);
  std::array<std::uint16_t, 4> words{};
  const std::vector<float>& normal = normalTable();
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % 4 == 0) {
      const std::uint64_t bits = engine();
      for (std::size_t k = 0; k < 4; ++k) words[k] = std::uint16_t(bits >> (16 * k));
    }
    const double signal = light_.background + double(light[i]);
    const double sd = std::sqrt(light_.read_noise * light_.read_noise + light_.shot_noise * signal);
    image.pixels[i] = std::uint8_t(std::clamp(std::lround(signal + sd * double(normal[words[i % 4]])), 0L, 255L));
  }
  return image;
}

}  // namespace simgap::reality
