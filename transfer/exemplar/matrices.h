/// \file
/// Images of one channel as OpenCV sees them.
#pragma once

#include "patinate/image/image.h"

namespace cv {
class Mat;
}

namespace patinate::transfer {

/// Matrix of the same memory, which must outlive it and is not written to. @param image  H x W x 1.
[[nodiscard]] cv::Mat matrix_of(const ImageF& image);
[[nodiscard]] cv::Mat matrix_of(const ImageU8& image);
/// Copies. @param matrix  CV_32F, CV_8U.
[[nodiscard]] ImageF float_image_of(const cv::Mat& matrix);
[[nodiscard]] ImageU8 byte_image_of(const cv::Mat& matrix);

}  // namespace patinate::transfer
