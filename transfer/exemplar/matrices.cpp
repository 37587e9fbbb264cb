#include "transfer/exemplar/matrices.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace patinate::transfer {

namespace {

template <class T>
cv::Mat view(const Image<T>& image, int type) {
  return {image.height(), image.width(), type, const_cast<T*>(image.data())};
}

template <class T>
Image<T> copy_of(const cv::Mat& matrix) {
  Image<T> image(matrix.cols, matrix.rows);
  for (int y = 0; y < matrix.rows; ++y) std::copy_n(matrix.ptr<T>(y), matrix.cols, image.row(y).begin());
  return image;
}

}  // namespace

cv::Mat matrix_of(const ImageF& image) { return view(image, CV_32F); }
cv::Mat matrix_of(const ImageU8& image) { return view(image, CV_8U); }
ImageF float_image_of(const cv::Mat& matrix) { return copy_of<float>(matrix); }
ImageU8 byte_image_of(const cv::Mat& matrix) { return copy_of<std::uint8_t>(matrix); }

}  // namespace patinate::transfer
