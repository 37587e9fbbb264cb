#include "patinate/analysis/comparison.h"

#include <utility>

#include "analysis/compare/sections.h"
#include "patinate/core/json.h"

namespace patinate::analysis {

std::vector<Section> compare(TextureSeries a, TextureSeries b, const CompareOptions& options,
                             const RunControl& control) {
  check_ranges(options);
  const ComparedPair pair = load_pair(std::move(a), std::move(b), options, control.part(0.0, 0.3));
  const std::vector<NamedSection> makers = compared_sections(options, pair.series_a.facts(), pair.series_b.facts());
  const double share = 0.7 / static_cast<double>(makers.size());
  std::vector<Section> sections;
  for (const NamedSection& section : makers) {
    const double begin = 0.3 + share * static_cast<double>(sections.size());
    sections.push_back(section.make(pair, options, control.part(begin, begin + share)));
  }
  control.report(1.0);
  return sections;
}

}  // namespace patinate::analysis
