#include "capture/timelapse/mask_warnings.h"

#include <algorithm>
#include <string>

#include "libcommon/core/text.h"

namespace patinate::capture {

double outside_share(const ImageU8& given, const ImageU8& result) {
  if (result.empty()) return 0.0;
  double num_given = 0.0, num_outside = 0.0;
  for (std::int64_t i = 0; i < result.num_pixels(); ++i) {
    if (!given.empty() && given.data()[i] == 0) continue;
    num_given += 1.0;
    num_outside += result.data()[i] == 0 ? 1.0 : 0.0;
  }
  return num_outside / std::max(1.0, num_given);
}

std::vector<HistoryWarning> mask_warnings(const ImageU8& given, const ImageU8& result, int num_frames) {
  const double share = outside_share(given, result);
  if (share < kMuchMasked) return {};
  const std::string what =
      num_frames == 1 ? " of the photograph's pixels are saturated or in a highlight: they are outside the mask"
                      : " of the pixels are saturated, in a highlight or out of view in some photograph and cannot be "
                        "filled from others: they are outside the mask";
  return {{.about = WarningSubject::Mask,
           .text = fixed_percent_text(share) + what,
           .cure = "use `--highlights keep`, or a smaller --highlight-width",
           .share = share}};
}

}  // namespace patinate::capture
